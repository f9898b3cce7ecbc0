#include "ground_cost.h"

#include "footprints.h"

#include <algorithm>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr int kBlock_cells = 4, kPlace_cells = 2;
constexpr float kCostNotAsked = -1;
constexpr double kEven_m =
    0.04;  // with the noise of a scanner; what it costs is not worth a detour

/** Whether a robot is the same after half a turn. */
bool is_symmetric(const Footprint& f)
{
  return f.min_x_m == -f.max_x_m && f.min_y_m == -f.max_y_m &&
         std::all_of(
             f.wheels.begin(), f.wheels.end(),
             [&f](const Point2& a)
             {
               return std::any_of(
                   f.wheels.begin(), f.wheels.end(),
                   [&a](const Point2& b) { return b.x_m == -a.x_m && b.y_m == -a.y_m; });
             });
}
}  // namespace

GroundCost::GroundCost(const Footprint& robot)
    : footprint_(robot), lines_(is_symmetric(robot) ? kHeadings / 2 : kHeadings)
{
}

void GroundCost::update(const MapView& map)
{
  window_ = map.window();
  blocks_ = (window_.cells + kBlock_cells - 1) / kBlock_cells;
  places_ = window_.cells / kPlace_cells;
  costs_.assign(static_cast<std::size_t>(places_ * places_ * lines_), kCostNotAsked);
  heights_.assign(static_cast<std::size_t>(blocks_ * blocks_), {HUGE_VALF, -HUGE_VALF});
  for (const Layer layer : {Layer::GroundElevation, Layer::Elevation})
  {
    const auto& height_m = map.layer(layer);
    for (int y = 0; y < window_.cells; y++)
      for (int x = 0; x < window_.cells; x++)
      {
        Range& r =
            heights_[static_cast<std::size_t>(y / kBlock_cells * blocks_ + x / kBlock_cells)];
        const float here_m = height_m[static_cast<std::size_t>(y * window_.cells + x)];
        r.low_m = std::fmin(r.low_m, here_m);  // NaN counts for nothing
        r.high_m = std::fmax(r.high_m, here_m);
      }
  }
}

int GroundCost::block_of(double at_m, double origin_m) const
{
  const double side_m = kBlock_cells * window_.resolution_m;
  return static_cast<int>(std::clamp((at_m - origin_m) / side_m, 0.0, blocks_ - 1.0));
}

/** Whether all blocks that the robot may touch, at any heading, are. */
bool GroundCost::is_even(const Point2& robot) const
{
  const int last_x = block_of(robot.x_m + footprint_.reach_m(), window_.min_x_m());
  const int last_y = block_of(robot.y_m + footprint_.reach_m(), window_.min_y_m());
  Range all{HUGE_VALF, -HUGE_VALF};
  for (int y = block_of(robot.y_m - footprint_.reach_m(), window_.min_y_m()); y <= last_y; y++)
    for (int x = block_of(robot.x_m - footprint_.reach_m(), window_.min_x_m()); x <= last_x; x++)
    {
      const Range& r = heights_[static_cast<std::size_t>(y * blocks_ + x)];
      all = {std::min(all.low_m, r.low_m), std::max(all.high_m, r.high_m)};
    }
  return all.high_m - all.low_m <= kEven_m;
}

double GroundCost::cost(const MapView& map, const Pose2& robot) const
{
  const double place_m = kPlace_cells * window_.resolution_m;
  const double x = (robot.x_m - window_.min_x_m()) / place_m;
  const double y = (robot.y_m - window_.min_y_m()) / place_m;
  if (!(x >= 0 && y >= 0 && x < places_ && y < places_)) return NAN;
  const auto column = static_cast<int>(x), row = static_cast<int>(y);
  const int heading = heading_of(robot.yaw_rad) % lines_;
  float& cost = costs_[static_cast<std::size_t>((row * places_ + column) * lines_ + heading)];
  if (cost != kCostNotAsked) return cost;
  const Point2 middle{
      window_.min_x_m() + (column + 0.5) * place_m, window_.min_y_m() + (row + 0.5) * place_m};
  cost = 0;
  if (!is_even(middle))
    cost = static_cast<float>(
        heading_cost(map, footprint_, Pose2{middle.x_m, middle.y_m, heading_rad(heading)}).cost);
  return cost;
}

}  // namespace talus::nav
