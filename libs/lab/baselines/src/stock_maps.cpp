#include <mrpt/maps/CHeightGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <talus/baselines/rivals.h>

#include <algorithm>
#include <cmath>

namespace talus::baselines
{
namespace
{
constexpr double kMaxGridCells = 3e7;  // a gigabyte

double center_m(std::int64_t cell, double resolution_m)
{
  return (static_cast<double>(cell) + 0.5) * resolution_m;
}

}  // namespace

OctoMapMethod::OctoMapMethod(const Parameters& parameters)
    : parameters_(parameters), map_(parameters.resolution_m)
{
  map_.insertionOptions.maxrange = parameters.window_m * std::sqrt(0.5);
}

void OctoMapMethod::update(const Frame& frame)
{
  T_map_sensor_ = frame.T_map_sensor;
  T_map_base_ = pose_of_base(frame.T_map_sensor, frame.T_base_sensor);
  // OctoMap numbers its voxels with 16 bits, and prints a line for each point that is farther away.
  const double farthest_m = 32767 * parameters_.resolution_m;
  const auto is_inside = [&](double x_m, double y_m, double z_m) {
    return std::max({std::abs(x_m), std::abs(y_m), std::abs(z_m)}) < farthest_m;
  };
  if (!is_inside(T_map_sensor_.x(), T_map_sensor_.y(), T_map_sensor_.z())) return;
  mrpt::maps::CSimplePointsMap cloud;
  cloud.reserve(frame.size);
  for (const MapPoint& p : accepted_points(frame, parameters_))
    if (is_inside(p.x_m, p.y_m, p.z_m)) cloud.insertPointFast(p.x_m, p.y_m, p.z_m);
  map_.insertPointCloud(
      cloud, static_cast<float>(T_map_sensor_.x()), static_cast<float>(T_map_sensor_.y()),
      static_cast<float>(T_map_sensor_.z()));
}

Column read_column(
    const std::vector<bool>& occupied, double first_z_m, double resolution_m, double clearance_m)
{
  Column column{NAN, NAN};
  double top_m = 0;  // upper side of what stands
  for (std::size_t i = 0; i < occupied.size(); ++i)
  {
    if (!occupied[i]) continue;
    const double center = first_z_m + static_cast<double>(i) * resolution_m;
    const bool first = std::isnan(column.ground_m);
    if (!first && center - 0.5 * resolution_m - top_m > clearance_m) break;
    if (first) column.ground_m = static_cast<float>(center);
    column.elevation_m = static_cast<float>(center);
    top_m = center + 0.5 * resolution_m;
  }
  return column;
}

Surfaces OctoMapMethod::read()
{
  Surfaces s(window_around(parameters_, T_map_base_));
  const double res = parameters_.resolution_m;
  const auto low = static_cast<std::int64_t>(
      std::floor((T_map_sensor_.z() + parameters_.min_height_m) / res) - 10);
  const auto high = static_cast<std::int64_t>(
      std::floor((T_map_sensor_.z() + parameters_.max_height_m) / res) + 10);
  std::vector<bool> occupied(static_cast<std::size_t>(high - low + 1));
  for (int iy = 0; iy < s.window.cells; ++iy)
    for (int ix = 0; ix < s.window.cells; ++ix)
    {
      const double x = center_m(s.window.min_cell_x + ix, res);
      const double y = center_m(s.window.min_cell_y + iy, res);
      for (std::int64_t iz = low; iz <= high; ++iz)
      {
        double p = 0;
        const bool mapped = map_.getPointOccupancy(
            static_cast<float>(x), static_cast<float>(y), static_cast<float>(center_m(iz, res)), p);
        occupied[iz - low] = mapped && p > 0.5;
      }
      const Column c = read_column(occupied, center_m(low, res), res, parameters_.clearance_m);
      if (std::isnan(c.ground_m)) continue;
      const auto i = static_cast<std::size_t>(iy * s.window.cells + ix);
      s.ground_m[i] = c.ground_m;
      s.elevation_m[i] = c.elevation_m;
      s.state[i] = static_cast<std::uint8_t>(CellState::Measured);
    }
  judge_two_surfaces(s, parameters_);
  return s;
}

namespace
{
/** mrpt::maps::CHeightGridMap2D: the mean of all heights ever seen in a cell. It takes no point
 * clouds and does not grow, so points are inserted one by one and the grid is resized here. A
 * position so far off that the grid would take more than a gigabyte begins a new one. */
class HeightGridMethod : public Method
{
 public:
  explicit HeightGridMethod(const Parameters& parameters) : parameters_(parameters) {}

  void update(const Frame& frame) override
  {
    T_map_base_ = pose_of_base(frame.T_map_sensor, frame.T_base_sensor);
    const Window w = window_around(parameters_, T_map_base_);
    const double x0 = w.min_x_m(), y0 = w.min_y_m(), side = w.cells * w.resolution_m;
    const auto cells_with = [&](double low_m, double high_m, double old_low_m, double old_high_m)
    { return (std::max(high_m, old_high_m) - std::min(low_m, old_low_m)) / w.resolution_m; };
    if (!map_ || cells_with(x0, x0 + side, map_->getXMin(), map_->getXMax()) *
                         cells_with(y0, y0 + side, map_->getYMin(), map_->getYMax()) >
                     kMaxGridCells)
      map_ =
          std::make_unique<Map>(Map::mrSimpleAverage, x0, x0 + side, y0, y0 + side, w.resolution_m);
    else
      map_->resize(x0, x0 + side, y0, y0 + side, mrpt::maps::THeightGridmapCell());
    for (const MapPoint& p : accepted_points(frame, parameters_))
      if (cell_index(w, p.x_m, p.y_m) >= 0) map_->insertIndividualPoint(p.x_m, p.y_m, p.z_m);
  }

  Surfaces read() override
  {
    Surfaces s(window_around(parameters_, T_map_base_));
    for (int iy = 0; iy < s.window.cells; ++iy)
      for (int ix = 0; ix < s.window.cells; ++ix)
      {
        double z = 0;
        const double res = s.window.resolution_m;
        const double x = center_m(s.window.min_cell_x + ix, res);
        const double y = center_m(s.window.min_cell_y + iy, res);
        if (!map_->dem_get_z(x, y, z)) continue;
        const auto i = static_cast<std::size_t>(iy * s.window.cells + ix);
        s.elevation_m[i] = s.ground_m[i] = static_cast<float>(z);
        s.state[i] = static_cast<std::uint8_t>(CellState::Measured);
      }
    judge_one_surface(s, parameters_);
    return s;
  }

 private:
  using Map = mrpt::maps::CHeightGridMap2D;

  Parameters parameters_;
  std::unique_ptr<Map> map_;
  Pose T_map_base_;
};
}  // namespace

std::unique_ptr<Method> make_heightgrid(const Parameters& parameters, Backend)
{
  return std::make_unique<HeightGridMethod>(parameters);
}

}  // namespace talus::baselines
