#pragma once
#include <mrpt/maps/CHeightGridMap2D.h>
#include <mrpt/maps/COctoMap.h>
#include <talus/baselines/method.h>

namespace talus::baselines
{
/** mrpt::maps::COctoMap with voxels as large as talus's cells. It gets the points inside range and
 * height band in the map frame with the true origin of their rays (insertPointCloud: the
 * observation's own path forgets the sensor's pose), rays cut where they leave the window. */
class OctoMapMethod : public Method
{
 public:
  explicit OctoMapMethod(const Parameters& parameters);
  void update(const Frame& frame) override;
  /** Columns become surfaces, see read_column(); judged by judge_two_surfaces(). */
  Surfaces read() override;

  mrpt::maps::COctoMap& map() { return map_; }

 private:
  Parameters parameters_;
  mrpt::maps::COctoMap map_;
  Pose T_map_sensor_, T_map_base_;
};

/** What a column of voxels says. */
struct Column
{
  float ground_m, elevation_m;  //!< NaN: no occupied voxel
};
/** Climbs a column from its lowest occupied voxel: voxels with gaps up to the clearance stand on
 * each other; at the first larger gap all above hangs. Heights are voxel centres. `occupied[i]` is
 * the voxel centred at first_z_m + i * resolution_m. */
Column read_column(
    const std::vector<bool>& occupied, double first_z_m, double resolution_m, double clearance_m);

/** mrpt::maps::CHeightGridMap2D: the mean of all heights ever seen in a cell. It takes no point
 * clouds and does not grow, so points are inserted one by one and the grid is resized here. A
 * position so far off that the grid would take more than a gigabyte begins a new one. */
class HeightGridMethod : public Method
{
 public:
  explicit HeightGridMethod(const Parameters& parameters);
  void update(const Frame& frame) override;
  Surfaces read() override;

 private:
  Parameters parameters_;
  std::unique_ptr<mrpt::maps::CHeightGridMap2D> map_;
  Pose T_map_base_;
};

}  // namespace talus::baselines
