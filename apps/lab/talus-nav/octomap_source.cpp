#include "map_source.h"

#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr float kFree = 0.9F;  // probability
constexpr double kVoxel_m = 0.1;
constexpr float kRange_m = 6;  // farther points are left out
constexpr double kLowest_m = 0.12, kHighest_m = 0.8;  // above the plane of the robot
constexpr std::size_t kDecimation = 2;  // takes one point of this number

class OctomapSource : public MapSource
{
 public:
  OctomapSource() { map_.insertionOptions.maxrange = kRange_m; }

  void insert(
      const sim::Scan& scan, const mrpt::poses::CPose3D& T_map_base,
      const mrpt::poses::CPose3D& T_base_sensor, double) override
  {
    const auto T_map_sensor = T_map_base + T_base_sensor;
    mrpt::maps::CSimplePointsMap points;
    for (std::size_t i = 0; i < scan.size(); i += kDecimation)
    {
      const double x_m = scan.x_m[i], y_m = scan.y_m[i], z_m = scan.z_m[i];
      if (std::hypot(x_m, y_m, z_m) > kRange_m) continue;
      const auto q = T_map_sensor.composePoint(mrpt::math::TPoint3D(x_m, y_m, z_m));
      points.insertPoint(static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z));
    }
    map_.insertPointCloud(
        points, static_cast<float>(T_map_sensor.x()), static_cast<float>(T_map_sensor.y()),
        static_cast<float>(T_map_sensor.z()));
  }

  Around look(
      const mrpt::poses::CPose3D& T_map_base, const std::vector<double>& prism_heights_m,
      double within_m) override
  {
    Around out;
    const double c = std::cos(T_map_base.yaw()), s = std::sin(T_map_base.yaw());
    for_each_voxel(
        T_map_base,
        [&](double x, double y, double height, bool occupied)
        {
          if (!occupied) return;
          const double dx = x - T_map_base.x(), dy = y - T_map_base.y();
          const double ahead_m = c * dx + s * dy, left_m = -s * dx + c * dy;
          out.obstacles.insertPoint(
              static_cast<float>(ahead_m), static_cast<float>(left_m),
              static_cast<float>(prism_heights_m.empty() ? 0.1 : height));
          if (std::hypot(ahead_m, left_m) < within_m)
            out.blocked.push_back({ahead_m, left_m, false});
        });
    return out;
  }

  void update_costmap(const mrpt::poses::CPose3D& T_map_base, Costmap& costmap) override
  {
    double last_x = NAN, last_y = NAN;  // voxels come column by column
    bool blocked = false;
    for_each_voxel(
        T_map_base,
        [&](double x, double y, double, bool occupied)
        {
          if (x != last_x || y != last_y) blocked = false;
          last_x = x;
          last_y = y;
          blocked = blocked || occupied;
          paint(costmap, x, y, blocked ? kObstacle : kFree);
        });
  }

 private:
  /** Calls f(x, y, height, occupied) for the known voxels at the heights that count: x and y in the
   * map frame, the height above the plane on which the robot stands. */
  template <class F>
  void for_each_voxel(const mrpt::poses::CPose3D& base, F f)
  {
    constexpr double side = kVoxel_m, reach = 4.0;
    const auto middle = [](double v) { return (std::floor(v / side) + 0.5) * side; };
    const auto middle_above = [](double v) { return (std::ceil(v / side - 0.5) + 0.5) * side; };
    const auto& R = base.getRotationMatrix();
    for (double x = middle(base.x() - reach); x < base.x() + reach; x += side)
      for (double y = middle(base.y() - reach); y < base.y() + reach; y += side)
      {
        const double tilt = R(0, 2) * (x - base.x()) + R(1, 2) * (y - base.y());
        const double plane = base.z() - tilt / R(2, 2);
        for (double z = middle_above(plane + kLowest_m); z < plane + kHighest_m; z += side)
        {
          double p = 0;
          if (map_.getPointOccupancy(
                  static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), p))
            f(x, y, z - plane, p > 0.5);
        }
      }
  }

  static void paint(Costmap& costmap, double x, double y, float p)
  {
    const double half = 0.5 * kVoxel_m;
    const auto cell = [&](double at_m, double min_m)
    { return static_cast<int>(std::floor((at_m - min_m) / costmap.resolution_m)); };
    const int last_x = std::min(cell(x + half - 1e-3, costmap.min_x_m()), costmap.columns - 1);
    const int last_y = std::min(cell(y + half - 1e-3, costmap.min_y_m()), costmap.rows - 1);
    for (int iy = std::max(cell(y - half + 1e-3, costmap.min_y_m()), 0); iy <= last_y; iy++)
      for (int ix = std::max(cell(x - half + 1e-3, costmap.min_x_m()), 0); ix <= last_x; ix++)
        costmap.free[costmap.index(ix, iy)] = p;
  }

  mrpt::maps::COctoMap map_{kVoxel_m};
};
}  // namespace

std::unique_ptr<MapSource> make_octomap_source() { return std::make_unique<OctomapSource>(); }

}  // namespace talus::nav
