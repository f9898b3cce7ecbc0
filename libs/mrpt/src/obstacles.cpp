#include <talus/mrpt/obstacles.h>

namespace talus
{
namespace
{
using mrpt::maps::CSimplePointsMap;
using mrpt::poses::CPose3D;

std::vector<Passage> judged_cells(
    const MapView& map, const CPose3D& T_map_base, const nav::ObstacleOptions& o)
{
  return map.empty() ? std::vector<Passage>() : nav::classify_cells(map, pose_from(T_map_base), o);
}
}  // namespace

void obstacles_2d(
    const MapView& map, const CPose3D& T_map_base, const nav::ObstacleOptions& o,
    CSimplePointsMap& out)
{
  obstacles_3d(map, T_map_base, o, judged_cells(map, T_map_base, o), {}, out);
}

void obstacles_2d(
    const MapView& map, const CPose3D& T_map_base, const nav::ObstacleOptions& o,
    const std::vector<Passage>& cells, CSimplePointsMap& out)
{
  obstacles_3d(map, T_map_base, o, cells, {}, out);
}

void obstacles_3d(
    const MapView& map, const CPose3D& T_map_base, const nav::ObstacleOptions& o,
    const std::vector<double>& prism_heights_m, CSimplePointsMap& out)
{
  obstacles_3d(map, T_map_base, o, judged_cells(map, T_map_base, o), prism_heights_m, out);
}

void obstacles_3d(
    const MapView& map, const CPose3D& T_map_base, const nav::ObstacleOptions& o,
    const std::vector<Passage>& cells, const std::vector<double>& prism_heights_m,
    CSimplePointsMap& out)
{
  out.clear();
  for (const auto& p : nav::find_obstacles(map, pose_from(T_map_base), o, cells, prism_heights_m))
    out.insertPointFast(p.x_m, p.y_m, p.z_m);
  out.mark_as_modified();
}

}  // namespace talus
