#include <talus/mrpt/heading_cost.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "surface_view.h"

namespace talus
{
namespace
{
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
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
  CellsBelow(const MapView& map, const mrpt::math::TPose2D& T_map_base)
      : window_(map.window()),
        ground_(map.layer(Layer::GroundElevation)),
        elevation_(map.layer(Layer::Elevation)),
        pose_(T_map_base),
        cos_(std::cos(pose_.phi)),
        sin_(std::sin(pose_.phi))
  {
  }

  /** visit(x, y, height) of each cell of the window whose middle lies within a rectangle of the
   * robot's frame; the height is NaN where nothing is known. */
  template <class Visit>
  void each_in(double min_x_m, double max_x_m, double min_y_m, double max_y_m, Visit visit) const
  {
    const double mid_x = (min_x_m + max_x_m) / 2, mid_y = (min_y_m + max_y_m) / 2;
    const double x = pose_.x + cos_ * mid_x - sin_ * mid_y;
    const double y = pose_.y + sin_ * mid_x + cos_ * mid_y;
    const double radius = std::hypot(max_x_m - min_x_m, max_y_m - min_y_m) / 2;
    const Window& w = window_;
    const auto cell = [&](double at_m, double origin_m)
    {
      return static_cast<int>(
          std::clamp(std::floor((at_m - origin_m) / w.resolution_m), -1.0, 1.0 * w.cells));
    };
    const int last_x = std::min(cell(x + radius, w.min_x_m()), w.cells - 1);
    const int last_y = std::min(cell(y + radius, w.min_y_m()), w.cells - 1);
    for (int iy = std::max(cell(y - radius, w.min_y_m()), 0); iy <= last_y; ++iy)
      for (int ix = std::max(cell(x - radius, w.min_x_m()), 0); ix <= last_x; ++ix)
      {
        const double dx = w.min_x_m() + (ix + 0.5) * w.resolution_m - pose_.x;
        const double dy = w.min_y_m() + (iy + 0.5) * w.resolution_m - pose_.y;
        const double ahead = cos_ * dx + sin_ * dy, left = cos_ * dy - sin_ * dx;
        if (ahead >= min_x_m && ahead <= max_x_m && left >= min_y_m && left <= max_y_m)
          visit(ahead, left, top(ix, iy));
      }
  }

  /** The same of a wheel. */
  template <class Visit>
  void each_under(const mrpt::math::TPoint2D& wheel, double radius_m, Visit visit) const
  {
    // At least the cell in which its middle lies.
    const double r = std::max(radius_m, 0.75 * window_.resolution_m);
    each_in(wheel.x - r, wheel.x + r, wheel.y - r, wheel.y + r, visit);
  }

 private:
  double top(int ix, int iy) const
  {
    const auto cell = static_cast<std::size_t>(iy) * static_cast<std::size_t>(window_.cells) +
                      static_cast<std::size_t>(ix);
    return detail::top_of(ground_[cell], elevation_[cell]);
  }

  Window window_;
  const std::vector<float>&ground_, &elevation_;
  mrpt::math::TPose2D pose_;
  double cos_, sin_;
};

/** Where a wheel rests, robot frame; z is NaN where nothing is known. */
struct Contact
{
  double x_m, y_m, z_m;
};

/** The highest of the cells under a wheel. */
Contact contact_of(
    const CellsBelow& cells, const mrpt::math::TPoint2D& wheel, const Footprint& robot)
{
  Contact highest{wheel.x, wheel.y, kNaN};
  cells.each_under(
      wheel, robot.wheel_radius_m,
      [&](double x, double y, double z)
      {
        if (z > highest.z_m || (std::isnan(highest.z_m) && !std::isnan(z))) highest = {x, y, z};
      });
  return highest;
}

/** The plane that lies nearest to all of them. */
Plane plane_through(const std::vector<Contact>& contacts)
{
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d products = Eigen::Vector3d::Zero();
  for (const Contact& c : contacts)
  {
    const Eigen::Vector3d row(1, c.x_m, c.y_m);
    squares += row * row.transpose();
    products += row * c.z_m;
  }
  const Eigen::Vector3d plane = squares.ldlt().solve(products);
  return {plane[0], plane[1], plane[2]};
}

double step_under(
    const CellsBelow& cells, const Footprint& robot, const mrpt::math::TPoint2D& wheel,
    const Plane& plane)
{
  double low = std::numeric_limits<double>::infinity(), high = -low;
  cells.each_under(
      wheel, robot.wheel_radius_m,
      [&](double x, double y, double z)
      {
        if (std::isnan(z)) return;
        low = std::min(low, plane.above(x, y, z));
        high = std::max(high, plane.above(x, y, z));
      });
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

void require_usable(const Footprint& robot, const mrpt::math::TPose2D& pose)
{
  if (!(std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.phi)))
    throw std::invalid_argument("heading_cost(): the pose is not finite");
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& w : robot.wheels) middle += Eigen::Vector2d(w.x, w.y);
  middle /= std::max(1.0, static_cast<double>(robot.wheels.size()));
  for (const auto& w : robot.wheels)
  {
    const Eigen::Vector2d from = Eigen::Vector2d(w.x, w.y) - middle;
    spread += from * from.transpose();
  }
  if (!(spread.determinant() > 1e-12))
    throw std::invalid_argument(
        "heading_cost(): the footprint needs three wheels or more that are not on one line");
  for (const double limit :
       {robot.wheel_radius_m, robot.ground_clearance_m, robot.max_along_rad, robot.max_across_rad,
        robot.max_step_m})
    if (!(limit > 0))
      throw std::invalid_argument("heading_cost(): a limit of the footprint is not above 0");
}
}  // namespace

HeadingCost heading_cost(
    const MapView& map, const Footprint& robot, const mrpt::math::TPose2D& T_map_base)
{
  require_usable(robot, T_map_base);
  if (map.empty()) return kUnknown;
  const CellsBelow cells(map, T_map_base);
  std::vector<Contact> contacts;
  for (const auto& wheel : robot.wheels)
  {
    contacts.push_back(contact_of(cells, wheel, robot));
    if (std::isnan(contacts.back().z_m)) return kUnknown;
  }
  const Plane plane = plane_through(contacts);
  HeadingCost found{std::atan(plane.along), std::atan(plane.across), 0, 0, 0};
  for (const auto& wheel : robot.wheels)
    found.step_m = std::max(found.step_m, step_under(cells, robot, wheel, plane));
  found.clearance_m = clearance_under(cells, robot, plane);
  found.cost = std::min(
      1.0, std::max({
               std::abs(found.along_rad) / robot.max_along_rad,
               std::abs(found.across_rad) / robot.max_across_rad,
               found.step_m / robot.max_step_m,
               1 - found.clearance_m / robot.ground_clearance_m,
           }));
  return found;
}

}  // namespace talus
