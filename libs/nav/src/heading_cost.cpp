#include <talus/nav/heading_cost.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "surface_view.h"

namespace talus::nav
{
namespace
{
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-6;  // of a cell
constexpr HeadingCost kUnknown{kNaN, kNaN, kNaN, kNaN, kNaN};

/** A plane z = z + along x + across y in the frame of the base. */
struct Plane
{
  double z_m, along, across;

  double above(double x_m, double y_m, double z) const
  {
    return z - (z_m + along * x_m + across * y_m);
  }
};

/** Cells around a robot, with their places in its frame. */
class CellsBelow
{
 public:
  CellsBelow(const MapView& map, const Pose2& T_map_base)
      : window_(map.window()),
        ground_(map.layer(Layer::GroundElevation)),
        elevation_(map.layer(Layer::Elevation)),
        pose_(T_map_base),
        cos_(std::cos(pose_.yaw_rad)),
        sin_(std::sin(pose_.yaw_rad))
  {
  }

  /** visit(x, y, height) of each cell of the window whose middle lies within a rectangle of the
   * robot's frame; the height is NaN where nothing is known. */
  template <class Visit>
  void each_in(double min_x_m, double max_x_m, double min_y_m, double max_y_m, Visit visit) const
  {
    const double mid_x = (min_x_m + max_x_m) / 2, mid_y = (min_y_m + max_y_m) / 2;
    const double half_x = (max_x_m - min_x_m) / 2, half_y = (max_y_m - min_y_m) / 2;
    const auto [first_x, last_x] = cells_between(
        pose_.x_m + cos_ * mid_x - sin_ * mid_y - window_.min_x_m(),
        std::abs(cos_) * half_x + std::abs(sin_) * half_y);
    const auto [first_y, last_y] = cells_between(
        pose_.y_m + sin_ * mid_x + cos_ * mid_y - window_.min_y_m(),
        std::abs(sin_) * half_x + std::abs(cos_) * half_y);
    const double resolution_m = window_.resolution_m;
    for (int iy = first_y; iy <= last_y; ++iy)
    {
      const double dy = window_.min_y_m() + (iy + 0.5) * resolution_m - pose_.y_m;
      for (int ix = first_x; ix <= last_x; ++ix)
      {
        const double dx = window_.min_x_m() + (ix + 0.5) * resolution_m - pose_.x_m;
        const double from_mid_x = cos_ * dx + sin_ * dy - mid_x;
        const double from_mid_y = cos_ * dy - sin_ * dx - mid_y;
        if (std::abs(from_mid_x) <= half_x && std::abs(from_mid_y) <= half_y)
          visit(mid_x + from_mid_x, mid_y + from_mid_y, top(ix, iy));
      }
    }
  }

  /** The same of a wheel. */
  template <class Visit>
  void each_under(const Point2& wheel, double radius_m, Visit visit) const
  {
    // At least the cell in which its middle lies.
    const double r = std::max(radius_m, 0.75 * window_.resolution_m);
    each_in(wheel.x_m - r, wheel.x_m + r, wheel.y_m - r, wheel.y_m + r, visit);
  }

 private:
  /** The first and the last of the cells of the window whose middles may lie within a distance of a
   * place, which is told from the border of the window. */
  std::pair<int, int> cells_between(double middle_m, double within_m) const
  {
    const auto cell = [&](double at_m)
    { return std::clamp(at_m / window_.resolution_m - 0.5, -1.0, 1.0 * window_.cells); };
    return {
        std::max(static_cast<int>(std::ceil(cell(middle_m - within_m) - kRounding)), 0),
        std::min(
            static_cast<int>(std::floor(cell(middle_m + within_m) + kRounding)),
            window_.cells - 1)};
  }
  double top(int ix, int iy) const
  {
    const auto cell = static_cast<std::size_t>(iy) * static_cast<std::size_t>(window_.cells) +
                      static_cast<std::size_t>(ix);
    return top_of(ground_[cell], elevation_[cell]);
  }

  Window window_;
  const std::vector<float>&ground_, &elevation_;
  Pose2 pose_;
  double cos_, sin_;
};

/** A spot on the map below, robot frame. */
struct Spot
{
  double x_m, y_m, z_m;
};

/** What is known under a wheel. */
std::vector<Spot> spots_under(const CellsBelow& cells, const Point2& wheel, const Footprint& robot)
{
  std::vector<Spot> out;
  out.reserve(32);
  cells.each_under(
      wheel, robot.wheel_radius_m,
      [&](double x, double y, double z)
      {
        if (!std::isnan(z)) out.push_back({x, y, z});
      });
  return out;
}

/** Where a wheel rests. */
const Spot& highest_of(const std::vector<Spot>& spots)
{
  return *std::max_element(
      spots.begin(), spots.end(), [](const Spot& a, const Spot& b) { return a.z_m < b.z_m; });
}

/** The plane that lies nearest to all of them. */
Plane plane_through(const std::vector<std::vector<Spot>>& wheels)
{
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d products = Eigen::Vector3d::Zero();
  for (const auto& spots : wheels)
  {
    const Spot& c = highest_of(spots);
    const Eigen::Vector3d row(1, c.x_m, c.y_m);
    squares += row * row.transpose();
    products += row * c.z_m;
  }
  const Eigen::Vector3d plane = squares.inverse() * products;
  return {plane[0], plane[1], plane[2]};
}

double step_under(const std::vector<Spot>& spots, const Plane& plane)
{
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Spot& p : spots)
  {
    low = std::min(low, plane.above(p.x_m, p.y_m, p.z_m));
    high = std::max(high, plane.above(p.x_m, p.y_m, p.z_m));
  }
  return high - low;
}

double clearance_under(const CellsBelow& cells, const Footprint& robot, const Plane& plane)
{
  double clearance = robot.ground_clearance_m;
  cells.each_in(
      robot.min_x_m, robot.max_x_m, robot.min_y_m, robot.max_y_m,
      [&](double x, double y, double z)
      {
        if (std::isnan(z)) return;
        clearance = std::min(clearance, robot.ground_clearance_m - plane.above(x, y, z));
      });
  return clearance;
}

void require_usable(const Footprint& robot, const Pose2& pose)
{
  if (!(std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.yaw_rad)))
    throw std::invalid_argument("heading_cost(): the pose is not finite");
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& w : robot.wheels) middle += Eigen::Vector2d(w.x_m, w.y_m);
  middle /= std::max(1.0, static_cast<double>(robot.wheels.size()));
  for (const auto& w : robot.wheels)
  {
    const Eigen::Vector2d from = Eigen::Vector2d(w.x_m, w.y_m) - middle;
    spread += from * from.transpose();
  }
  if (!(spread.determinant() > 1e-12))
    throw std::invalid_argument(
        "heading_cost(): the footprint needs three wheels or more that are not on one line");
  for (const double limit :
       {robot.wheel_radius_m, robot.ground_clearance_m, robot.max_along_rad, robot.max_across_rad,
        robot.max_step_m, robot.max_x_m - robot.min_x_m, robot.max_y_m - robot.min_y_m})
    if (!(limit > 0))
      throw std::invalid_argument(
          "heading_cost(): a limit or side of the footprint is not above 0");
}
}  // namespace

HeadingCost heading_cost(const MapView& map, const Footprint& robot, const Pose2& T_map_base)
{
  require_usable(robot, T_map_base);
  if (map.empty()) return kUnknown;
  const CellsBelow cells(map, T_map_base);
  std::vector<std::vector<Spot>> wheels;
  for (const auto& wheel : robot.wheels)
  {
    wheels.push_back(spots_under(cells, wheel, robot));
    if (wheels.back().empty()) return kUnknown;
  }
  const Plane plane = plane_through(wheels);
  HeadingCost found{std::atan(plane.along), std::atan(plane.across), 0, 0, 0};
  for (const auto& spots : wheels) found.step_m = std::max(found.step_m, step_under(spots, plane));
  found.clearance_m = clearance_under(cells, robot, plane);
  found.cost = std::min(
      1.0, std::max({
               std::hypot(
                   found.along_rad / robot.max_along_rad, found.across_rad / robot.max_across_rad),
               found.step_m / robot.max_step_m,
               1 - found.clearance_m / robot.ground_clearance_m,
           }));
  return found;
}

}  // namespace talus::nav
