#include <talus/nav/obstacles.h>
#include <talus/risk.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "falls.h"
#include "surface_view.h"

namespace talus::nav
{
namespace
{
/** A comparison with NaN, or a choice that is none, makes nothing an obstacle. */
void require_sound(const Pose& T, const ObstacleOptions& o)
{
  if (!std::isfinite(std::accumulate(T.m.begin(), T.m.end(), 0.0)))
    throw std::invalid_argument("the pose of the robot among the obstacles is not finite");
  if (std::isnan(
          o.blocked_at + o.risk_at + o.seen_within_m + o.body_radius_m + o.range_m + o.spacing_m +
          o.z_m))
    throw std::invalid_argument("a number of the ObstacleOptions is NaN");
  if (o.unseen != Unseen::Obstacle && o.unseen != Unseen::Free)
    throw std::invalid_argument(
        "unseen of the ObstacleOptions is " + std::to_string(static_cast<int>(o.unseen)) +
        ", none of Unseen");
  if (o.drops != Drops::Avoid && o.drops != Drops::Slope && o.drops != Drops::Ignore)
    throw std::invalid_argument(
        "drops of the ObstacleOptions is " + std::to_string(static_cast<int>(o.drops)) +
        ", none of Drops");
}

/** Something measured, on the ground of the cell. */
bool something_stands(const SurfaceView& view, std::size_t cell)
{
  return view.elevation[cell] - view.ground[cell] > kObject_m;  // false for NaN
}

/** So near to what stands nothing is an edge just because it was not seen: no robot fits between.
 */
constexpr double kBeside_m = 0.2;
constexpr float kRim_m =
    0.05;  // a cell at a rim holds points of both levels, and nothing stands there

/** So near to what may drop a guess is no ground, with Drops::Avoid: a fill across the corner of a
 * trench has measured ground on both sides. */
constexpr double kBesideDrop_m = 0.2;

/** So narrow a gap in what is known hides no edge, but for the tip of a corner. */
constexpr int kGap_cells = 3;
/** Along so many of four lines known ground lies around such a gap, and not beyond a corner. */
constexpr int kSurrounded = 3;
constexpr double kGentleGap_m = 0.03;  // beside a slope, with the noise of the ground

/** Whether something holds for all cells of the window up to so many rows and columns away. */
template <class Holds>
bool holds_around(const Window& window, int ix, int iy, int reach, const Holds& holds)
{
  const int last = window.cells - 1;
  for (int y = std::max(0, iy - reach); y <= std::min(last, iy + reach); y++)
    for (int x = std::max(0, ix - reach); x <= std::min(last, ix + reach); x++)
      if (!holds(x, y)) return false;
  return true;
}

int cells_of(const MapView& map, double distance_m)
{
  return static_cast<int>(std::lround(distance_m / map.parameters().resolution_m));
}

/** What is around a cell. */
class Surroundings
{
 public:
  explicit Surroundings(const MapView& map)
      : view_(map), step_m_(map.parameters().step_threshold_m), reach_(cells_of(map, kBeside_m))
  {
  }

  /** For a robot whose base is at this height. */
  bool is_edge(int ix, int iy, double level_m) const
  {
    const Around around = of(ix, iy);
    const bool stands =
        around.highest_m > level_m + step_m_ || around.top_m > around.highest_m + kRim_m;
    return !stands || around.lowest_m < level_m - step_m_;
  }
  /** Beside a wall that is higher than such a robot, and with no lower ground: not in a ditch. */
  bool is_beside_wall(int ix, int iy, double level_m) const
  {
    const Around around = of(ix, iy);
    return around.top_m > level_m + step_m_ && around.lowest_m > level_m - kObject_m;
  }

 private:
  struct Around
  {
    float lowest_m = HUGE_VALF, highest_m = -HUGE_VALF;  //!< ground
    float top_m = -HUGE_VALF;  //!< of what stands
  };
  Around of(int ix, int iy) const
  {
    Around out;
    holds_around(
        view_.window, ix, iy, reach_,
        [&](int x, int y)
        {
          const std::size_t cell = view_.index(x, y);
          out.lowest_m = std::fmin(out.lowest_m, view_.ground[cell]);  // NaN counts for nothing
          out.highest_m = std::fmax(out.highest_m, view_.ground[cell]);
          if (something_stands(view_, cell)) out.top_m = std::max(out.top_m, view_.elevation[cell]);
          return true;
        });
    return out;
  }

  SurfaceView view_;
  double step_m_;
  int reach_;
};

/** The questions that are asked of a cell. */
class Judge
{
 public:
  /** `level_m`: where the robot stands; NaN: not known, and nothing is the foot of a wall. */
  Judge(const MapView& map, double level_m, const ObstacleOptions& o)
      : view_(map),
        level_m_(level_m),
        around_(map),
        o_(o),
        reach_(cells_of(map, map.parameters().feature_radius_m)),
        beside_drop_(cells_of(map, kBesideDrop_m)),
        step_m_(static_cast<float>(map.parameters().step_threshold_m)),
        gentle_(std::tan(map.parameters().slope_threshold_rad) * map.parameters().resolution_m / 2)
  {
    if (o.risk_at < 1) risk_ = risk(map);
    if (o.drops == Drops::Slope)
      falls_.emplace(map, [this](int ix, int iy) { return rests_on_unseen(ix, iy); });
  }
  Judge(const Judge&) = delete;
  Judge& operator=(const Judge&) = delete;

  const SurfaceView& view() const { return view_; }

  bool is_unknown(int ix, int iy) const
  {
    return std::isnan(view_.traversability[view_.index(ix, iy)]);
  }

  /** Blocked only by comparison with ground that nobody saw, which may look better from nearby, and
   * not to be dared. */
  bool is_doubtful(int ix, int iy) const { return rests_on_unseen(ix, iy) && !is_dared(ix, iy); }

  Passage operator()(int ix, int iy, double distance_m) const
  {
    if (distance_m < o_.body_radius_m) return Passage::Free;
    const bool near = distance_m <= o_.seen_within_m;
    const bool must_be_seen = near && o_.unseen == Unseen::Obstacle;
    if (is_unknown(ix, iy)) return must_be_seen ? Passage::Obstacle : Passage::Unknown;
    if (must_be_seen && is_guess(ix, iy) && !around_.is_beside_wall(ix, iy, level_m_))
      return Passage::Obstacle;
    if (!blocks(ix, iy)) return Passage::Free;
    if (!rests_on_unseen(ix, iy)) return Passage::Obstacle;
    if (is_dared(ix, iy)) return Passage::Free;
    return near ? Passage::Obstacle : Passage::Unknown;
  }

 private:
  /** Made from one side, where the ground goes on as far as one knows: with Drops::Avoid, as an
   * edge in the blind zone of the scanner looks so. Or beside what may drop and is not dared. */
  bool is_guess(int ix, int iy) const
  {
    const std::size_t cell = view_.index(ix, iy);
    if (!is_filled(cell)) return false;
    const bool one_sided = o_.drops == Drops::Avoid &&
                           view_.state[cell] == static_cast<float>(CellState::FilledOneSided);
    const int gaps = gaps_at(ix, iy, kGap_cells);
    return (one_sided && gaps == 0) ||
           (gaps < kSurrounded && !something_stands(view_, cell) && is_beside_drop(ix, iy));
  }
  bool is_beside_drop(int ix, int iy) const
  {
    return !holds_around(
        view_.window, ix, iy, beside_drop_, [&](int x, int y) { return !is_doubtful(x, y); });
  }
  bool is_filled(std::size_t cell) const
  {
    const float state = view_.state[cell];
    return state == static_cast<float>(CellState::FilledOneSided) ||
           state == static_cast<float>(CellState::FilledTwoSided);
  }
  bool is_measured(std::size_t cell) const
  {
    return view_.state[cell] == static_cast<float>(CellState::Measured);
  }
  bool rests_on_unseen(int ix, int iy) const
  {
    return blocks(ix, iy) && !something_stands(view_, view_.index(ix, iy)) &&
           rests_on_fills(ix, iy);
  }
  bool blocks(int ix, int iy) const
  {
    const std::size_t cell = view_.index(ix, iy);
    return is_risky(cell) || (view_.traversability[cell] <= o_.blocked_at && !is_foot(ix, iy) &&
                              !is_seen_around(ix, iy));
  }
  /** Although the map lets it pass. */
  bool is_risky(std::size_t cell) const
  {
    return !risk_.empty() && risk_[cell] > o_.risk_at && view_.traversability[cell] > 0;
  }
  /** Blocked only because ground may drop in a gap that is a cell wide between measured ground, as
   * the memory of a crest that was seen from afar: nothing can fall into it. */
  bool is_seen_around(int ix, int iy) const
  {
    const std::size_t cell = view_.index(ix, iy);
    bool gap = false;
    const auto is_gentle = [&](int x, int y)
    {
      const std::size_t other = view_.index(x, y);
      const bool filled = view_.state[other] == static_cast<float>(CellState::FilledTwoSided);
      gap = gap || filled;
      const double most_m = kGentleGap_m + gentle_ * std::hypot(x - ix, y - iy);
      return (filled ? gaps_at(x, y, 1) > 0 : is_measured(other)) &&
             !something_stands(view_, other) &&
             std::abs(view_.ground[other] - view_.ground[cell]) <= most_m;
    };
    return holds_around(view_.window, ix, iy, reach_, is_gentle) && gap;
  }
  /** Along how many of four lines a filled cell lies in a gap, at most so many cells wide, between
   * ground that was measured or stood on. */
  int gaps_at(int ix, int iy, int most_cells) const
  {
    int gaps = 0;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}})
    {
      const int before = filled_from(ix, iy, -dx, -dy, most_cells);
      const int behind = filled_from(ix, iy, dx, dy, most_cells);
      if (before + 1 + behind <= most_cells) gaps++;
    }
    return gaps;
  }
  /** How many filled cells there are up to the first one that is known; more than `most_cells`
   * where there is none. */
  int filled_from(int ix, int iy, int dx, int dy, int most_cells) const
  {
    const int last = view_.window.cells - 1;
    for (int i = 1; i <= most_cells; i++)
    {
      const int x = ix + i * dx, y = iy + i * dy;
      if (x < 0 || y < 0 || x > last || y > last) break;
      const float state = view_.state[view_.index(x, y)];
      if (state == static_cast<float>(CellState::Measured) ||
          state == static_cast<float>(CellState::Presumed))
        return i - 1;
      if (!is_filled(view_.index(x, y))) break;
    }
    return most_cells + 1;
  }
  /** Blocked only because something higher begins beside it: there the robot may stand, and the
   * planner, which knows its shape, keeps it away from what stands. */
  bool is_foot(int ix, int iy) const
  {
    const std::size_t cell = view_.index(ix, iy);
    const float ground_m = view_.ground[cell];
    // False for NaN; and the bottom of a ditch is no place to stand.
    if (!(ground_m > level_m_ - kObject_m) || something_stands(view_, cell)) return false;
    bool rises = false, is_sure = false;
    const auto is_no_lower = [&](int x, int y)
    {
      const std::size_t other = view_.index(x, y);
      const bool higher = view_.top(other) > ground_m + step_m_;
      rises = rises || higher;
      is_sure = is_sure || (higher && is_measured(other));
      return !(view_.ground[other] < ground_m - kObject_m);
    };
    if (!holds_around(view_.window, ix, iy, reach_, is_no_lower)) return false;
    return rises && (is_sure || around_.is_beside_wall(ix, iy, level_m_));
  }
  bool is_dared(int ix, int iy) const
  {
    return falls_ ? falls_->is_slope(ix, iy) : o_.drops == Drops::Ignore;
  }

  /** Slope and step of the cell were made from inferred ground too. */
  bool rests_on_fills(int ix, int iy) const
  {
    return !holds_around(
        view_.window, ix, iy, reach_, [&](int x, int y) { return !is_filled(view_.index(x, y)); });
  }

  std::optional<Falls> falls_;  //!< where they are asked for
  SurfaceView view_;
  double level_m_;
  Surroundings around_;
  const ObstacleOptions& o_;
  int reach_;  //!< of the neighbourhood of slope and step, in cells
  int beside_drop_;  //!< kBesideDrop_m in cells
  float step_m_;
  double gentle_;  //!< that ground may rise from a cell to the next one: half of what is too steep
  std::vector<float> risk_;  //!< empty: it does not count
};

/** An arc from the base on, robot frame seen from above. */
class Arc
{
 public:
  Arc(double v_mps, double w_radps)
      : sign_(v_mps < 0 ? -1 : 1),
        straight_(std::abs(w_radps) < 1e-3 * std::abs(v_mps)),
        radius_m_(straight_ ? 0 : v_mps / w_radps)
  {
  }

  /** Where a place lies along it; negative: behind. */
  double along_m(double x_m, double y_m) const
  {
    const double ahead_m = sign_ * x_m;
    if (straight_) return ahead_m;
    const double to_middle_m = std::copysign(1.0, radius_m_) * (radius_m_ - y_m);
    return std::abs(radius_m_) * std::atan2(ahead_m, to_middle_m);
  }
  double beside_m(double x_m, double y_m) const
  {
    if (straight_) return std::abs(y_m);
    return std::abs(std::hypot(x_m, y_m - radius_m_) - std::abs(radius_m_));
  }

 private:
  double sign_;
  bool straight_;
  double radius_m_;  //!< its centre is there to the left
};

double to_border_m(const Window& w, const Pose& T)
{
  const double side_m = w.cells * w.resolution_m;
  const double x = T.x() - w.min_x_m(), y = T.y() - w.min_y_m();
  return std::max(0.0, std::min({x, y, side_m - x, side_m - y}));
}
}  // namespace

JudgedCells judge_cells(const MapView& map, const Pose& T_map_base, const ObstacleOptions& o)
{
  require_sound(T_map_base, o);
  const Judge judge(map, T_map_base.z(), o);
  const SurfaceView& view = judge.view();
  const int n = view.window.cells;
  JudgedCells out;
  out.passages.reserve(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  out.doubtful.reserve(out.passages.capacity());
  for (int iy = 0; iy < n; iy++)
    for (int ix = 0; ix < n; ix++)
    {
      const double distance_m =
          std::hypot(view.x_m(ix) - T_map_base.x(), view.y_m(iy) - T_map_base.y());
      out.passages.push_back(judge(ix, iy, distance_m));
      out.doubtful.push_back(judge.is_doubtful(ix, iy));
    }
  return out;
}

std::vector<Passage> classify_cells(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o)
{
  return judge_cells(map, T_map_base, o).passages;
}

std::vector<bool> find_doubtful(const MapView& map, const ObstacleOptions& o)
{
  require_sound({}, o);
  const Judge judge(map, NAN, o);
  const int n = judge.view().window.cells;
  std::vector<bool> out;
  out.reserve(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  for (int iy = 0; iy < n; iy++)
    for (int ix = 0; ix < n; ix++) out.push_back(judge.is_doubtful(ix, iy));
  return out;
}

std::vector<bool> find_edges(
    const MapView& map, const Pose& T_map_base, const std::vector<Passage>& cells)
{
  const Surroundings around(map);
  const auto& traversability = map.layer(Layer::Traversability);
  const int n = map.window().cells;
  std::vector<bool> out(cells.size(), false);
  for (std::size_t i = 0; i < cells.size(); i++)
  {
    const bool in_doubt = cells[i] == Passage::Unknown && !std::isnan(traversability[i]);
    if (cells[i] == Passage::Obstacle || in_doubt)
      out[i] = around.is_edge(static_cast<int>(i) % n, static_cast<int>(i) / n, T_map_base.z());
  }
  return out;
}

double known_ahead_m(
    const MapView& map, const Pose& T_map_base, double v_mps, double w_radps, double width_m,
    const ObstacleOptions& o)
{
  if (map.empty()) return 0;
  require_sound(T_map_base, o);
  if (v_mps == 0) return o.range_m;
  const Judge judge(map, T_map_base.z(), o);
  const SurfaceView& view = judge.view();
  const Arc arc(v_mps, w_radps);
  const double yaw_rad = yaw_of(T_map_base), c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  double known_m = std::min(o.range_m, to_border_m(view.window, T_map_base));
  for (int iy = 0; iy < view.window.cells; iy++)
    for (int ix = 0; ix < view.window.cells; ix++)
    {
      const double dx = view.x_m(ix) - T_map_base.x(), dy = view.y_m(iy) - T_map_base.y();
      if (std::hypot(dx, dy) < o.body_radius_m) continue;
      const double x = c * dx + s * dy, y = -s * dx + c * dy;
      const double along_m = arc.along_m(x, y);
      if (along_m >= 0 && along_m < known_m && arc.beside_m(x, y) <= width_m / 2 &&
          (judge.is_unknown(ix, iy) || judge.is_doubtful(ix, iy)))
        known_m = along_m;
    }
  return known_m;
}

double stopping_speed_mps(double distance_m, double reaction_s, double deceleration_mps2)
{
  if (!(distance_m > 0)) return 0;
  const double lost_mps = deceleration_mps2 * reaction_s;
  return std::sqrt(lost_mps * lost_mps + 2 * deceleration_mps2 * distance_m) - lost_mps;
}

}  // namespace talus::nav
