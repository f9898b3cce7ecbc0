#pragma once
#include <talus/mrpt/obstacles.h>

#include <vector>

namespace talus::detail
{
/** What classify_cells() and find_doubtful() say, judged once. */
struct JudgedCells
{
  std::vector<Passage> passages;
  std::vector<bool> doubtful;
};
JudgedCells judge_cells(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& o);

}  // namespace talus::detail
