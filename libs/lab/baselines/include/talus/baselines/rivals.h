#pragma once
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

/** Fills `traversability` as grid filters do on one surface, `elevation_m`: in the square
 * neighbourhood of feature_radius_m, unknown cells left out,
 * - slope: angle of the least-squares plane, over slope_threshold_rad;
 * - step: greatest height difference to the cell, over step_threshold_m;
 * - roughness: RMS distance from that plane, over roughness_threshold_m;
 * and their weighted sum, zero where any is zero (eq. 13 with unsigned features). Fewer than three
 * known cells: slope and roughness count as perfect. */
void judge_one_surface(Surfaces& surfaces, const Parameters& parameters);

/** The same for maps with a ground below the elevation: slope and step on `ground_m`, and blocked
 * where the elevation stands more than step_threshold_m above the ground. */
void judge_two_surfaces(Surfaces& surfaces, const Parameters& parameters);

/// @name Methods of make_method(), of which each source says what it does
/// @{
std::unique_ptr<Method> make_paper(const Parameters& parameters, Backend);
std::unique_ptr<Method> make_heightgrid(const Parameters& parameters, Backend);
std::unique_ptr<Method> make_highest(const Parameters& parameters, Backend);
std::unique_ptr<Method> make_cucpp(const Parameters& parameters, Backend);
std::unique_ptr<Method> make_cupy(const Parameters& parameters, Backend);
/// @}

}  // namespace talus::baselines
