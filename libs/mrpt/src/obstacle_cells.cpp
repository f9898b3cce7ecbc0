#include <talus/mrpt/obstacles.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "surface_view.h"

namespace talus
{
namespace
{
using detail::SurfaceView;

constexpr double kObject_m = 0.1;  // lower than this nothing stands in the way

/** The questions that classify_cells() asks of a cell. */
class Judge
{
 public:
  Judge(const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& o)
      : view_(map),
        sparsity_(map.layer(Layer::Sparsity)),
        base_(T_map_base),
        o_(o),
        reach_(static_cast<int>(
            std::lround(map.parameters().feature_radius_m / map.parameters().resolution_m)))
  {
  }

  Passage operator()(int ix, int iy) const
  {
    const std::size_t cell = view_.index(ix, iy);
    const double distance_m = std::hypot(view_.x_m(ix) - base_.x(), view_.y_m(iy) - base_.y());
    const float traversability = view_.traversability[cell];
    if (distance_m < o_.body_radius_m) return Passage::Free;
    if (std::isnan(traversability))
      return counts(o_.unknown, distance_m) ? Passage::Obstacle : Passage::Unknown;
    if (traversability <= o_.blocked_at &&
        (stands(cell) || !rests_on_fills(ix, iy) || counts(o_.inferred, distance_m)))
      return Passage::Obstacle;
    if (!is_guess(cell)) return Passage::Free;
    const bool risky = sparsity_[cell] < o_.risky_below;  // false for NaN
    return counts(risky ? o_.risky : o_.one_sided, distance_m) ? Passage::Obstacle : Passage::Free;
  }

 private:
  bool counts(CellPolicy policy, double distance_m) const
  {
    if (distance_m < o_.own_radius_m) return false;
    return policy == CellPolicy::Obstacle ||
           (policy == CellPolicy::Near && distance_m <= o_.near_m);
  }

  /** Inferred ground, and nothing seen on it. */
  bool is_filled(std::size_t cell) const
  {
    return view_.state[cell] != static_cast<float>(CellState::Measured) &&
           std::isnan(view_.elevation[cell]);
  }

  /** The same, inferred from one side. */
  bool is_guess(std::size_t cell) const
  {
    return is_filled(cell) && view_.state[cell] == static_cast<float>(CellState::FilledOneSided);
  }

  /** Something measured stands on the ground of the cell. */
  bool stands(std::size_t cell) const
  {
    return view_.elevation[cell] - view_.ground[cell] > kObject_m;  // false for NaN
  }

  /** Slope and step of the cell were made from inferred ground too. */
  bool rests_on_fills(int ix, int iy) const
  {
    const int last = view_.window.cells - 1;
    for (int y = std::max(0, iy - reach_); y <= std::min(last, iy + reach_); y++)
      for (int x = std::max(0, ix - reach_); x <= std::min(last, ix + reach_); x++)
        if (is_filled(view_.index(x, y))) return true;
    return false;
  }

  SurfaceView view_;
  const std::vector<float>& sparsity_;
  const mrpt::poses::CPose3D& base_;
  const ObstacleOptions& o_;
  int reach_;  //!< of the neighbourhood of slope and step, in cells
};

/** A comparison with NaN, or a policy that is none, makes nothing an obstacle. */
void require_sound(const mrpt::poses::CPose3D& T, const ObstacleOptions& o)
{
  if (!std::isfinite(T.x() + T.y() + T.z() + T.yaw() + T.pitch() + T.roll()))
    throw std::invalid_argument("the pose of the robot among the obstacles is not finite");
  if (std::isnan(
          o.blocked_at + o.risky_below + o.near_m + o.body_radius_m + o.own_radius_m + o.range_m +
          o.spacing_m + o.z_m))
    throw std::invalid_argument("a number of the ObstacleOptions is NaN");
  for (const CellPolicy policy : {o.unknown, o.one_sided, o.risky, o.inferred})
    if (policy != CellPolicy::Free && policy != CellPolicy::Near && policy != CellPolicy::Obstacle)
      throw std::invalid_argument(
          "a policy of the ObstacleOptions is " + std::to_string(static_cast<int>(policy)) +
          ", none of CellPolicy");
}
}  // namespace

std::vector<Passage> classify_cells(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& o)
{
  require_sound(T_map_base, o);
  const Judge judge(map, T_map_base, o);
  const int cells = map.window().cells;
  std::vector<Passage> out;
  out.reserve(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
  for (int iy = 0; iy < cells; iy++)
    for (int ix = 0; ix < cells; ix++) out.push_back(judge(ix, iy));
  return out;
}

}  // namespace talus
