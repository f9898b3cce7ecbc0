#pragma once
#include <talus/mrpt/version_compat.h>

#if MRPT_VERSION >= 0x020b03
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/maps/NearestNeighborsCapable.h>

#include <vector>
#endif

namespace talus
{
#if MRPT_VERSION >= 0x020b03
/** The neighbours of a place among points that a map gives, for programs such as mp2p_icp: indices
 * are those of the points. */
class NearestPoints : public mrpt::maps::NearestNeighborsCapable
{
 public:
  // As NearestNeighborsCapable documents them.
  /// @cond
  bool nn_has_indices_or_ids() const override { return true; }
  std::size_t nn_index_count() const override { return nn_points().size(); }
  void nn_prepare_for_2d_queries() const override { nn_points().nn_prepare_for_2d_queries(); }
  void nn_prepare_for_3d_queries() const override { nn_points().nn_prepare_for_3d_queries(); }
  bool nn_single_search(
      const mrpt::math::TPoint3Df& query, mrpt::math::TPoint3Df& result, float& distance2,
      std::uint64_t& index) const override
  {
    return nn_points().nn_single_search(query, result, distance2, index);
  }
  bool nn_single_search(
      const mrpt::math::TPoint2Df& query, mrpt::math::TPoint2Df& result, float& distance2,
      std::uint64_t& index) const override
  {
    return nn_points().nn_single_search(query, result, distance2, index);
  }
  void nn_multiple_search(
      const mrpt::math::TPoint3Df& query, std::size_t count,
      std::vector<mrpt::math::TPoint3Df>& results, std::vector<float>& distances2,
      std::vector<std::uint64_t>& indices) const override
  {
    nn_points().nn_multiple_search(query, count, results, distances2, indices);
  }
  void nn_multiple_search(
      const mrpt::math::TPoint2Df& query, std::size_t count,
      std::vector<mrpt::math::TPoint2Df>& results, std::vector<float>& distances2,
      std::vector<std::uint64_t>& indices) const override
  {
    nn_points().nn_multiple_search(query, count, results, distances2, indices);
  }
  void nn_radius_search(
      const mrpt::math::TPoint3Df& query, float radius2,
      std::vector<mrpt::math::TPoint3Df>& results, std::vector<float>& distances2,
      std::vector<std::uint64_t>& indices, std::size_t most) const override
  {
    nn_points().nn_radius_search(query, radius2, results, distances2, indices, most);
  }
  void nn_radius_search(
      const mrpt::math::TPoint2Df& query, float radius2,
      std::vector<mrpt::math::TPoint2Df>& results, std::vector<float>& distances2,
      std::vector<std::uint64_t>& indices, std::size_t most) const override
  {
    nn_points().nn_radius_search(query, radius2, results, distances2, indices, most);
  }

 protected:
  virtual const mrpt::maps::CSimplePointsMap& nn_points() const = 0;
  /// @endcond
};
#else
/** MRPT asks for no neighbours before 2.11.3. */
class NearestPoints
{
};
#endif

}  // namespace talus
