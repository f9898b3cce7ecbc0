#include <talus/baselines/fills.h>
#include <talus/baselines/rivals.h>
#include <talus/baselines/window_cells.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::baselines
{
namespace
{
constexpr float kCleanupDeviations = 3.0f;

/** Height below which the rays to the lowest points of all cells passed; NaN: none did. */
std::vector<float> ray_bounds(
    const Window& window, const Pose& T_map_sensor, const std::vector<MapPoint>& points)
{
  const std::vector<float> lowest = lowest_points(points, window);
  std::vector<float> bound(lowest.size(), NAN);
  for (std::size_t i = 0; i < lowest.size(); ++i)
  {
    if (std::isnan(lowest[i])) continue;
    const int cell = static_cast<int>(i);
    const CellLine line(window, T_map_sensor, cell % window.cells, cell / window.cells);
    for (int s = 1; s < line.steps(); ++s)
    {
      const int at = line(s);
      if (at < 0) continue;  // the sensor is outside
      const double t = static_cast<double>(s) / line.steps();
      const double z_m = T_map_sensor.z() + t * (lowest[i] - T_map_sensor.z());
      float& b = bound[at];
      b = std::fmin(b, static_cast<float>(z_m));
    }
  }
  return bound;
}

constexpr float kGate_deviations = 2.5f;  //!< Mahalanobis distance, as elevation_mapping's default
constexpr double kCleanupPeriod_s = 1.0;

// The numbers of its default configuration.
constexpr float kGate = 2.0f;  //!< Mahalanobis distance
constexpr float kOutlier_m2 = 0.01f;  //!< added to the variance by a point outside the gate
constexpr float kTime_m2ps = 1e-3f;  //!< added a second
constexpr float kTrusted_m2 = 0.05f, kFlat = 0.9f;  //!< cells that drift is measured on
constexpr double kMaxDrift_m = 0.1;  //!< a larger mean is none
constexpr double kDriftShare = 0.1;  //!< of the mean error that a frame makes up for
constexpr float kConeFrom_m = 1.0f, kConeRise = 0.3f, kConeLow_m = 0.2f;

/** Higher above the sensor than the cone. */
bool is_overhead(const MapPoint& p, const Pose& T_map_sensor)
{
  const auto distance_m =
      static_cast<float>(std::hypot(p.x_m - T_map_sensor.x(), p.y_m - T_map_sensor.y()));
  const float rise_m = p.z_m - static_cast<float>(T_map_sensor.z());
  return rise_m > std::max(distance_m - kConeFrom_m, 0.0f) * kConeRise + kConeLow_m;
}

/** What robot-centric elevation maps with one surface have in common: heights with a variance in a
 * window that rolls, points that are taken in one by one, in the order of the frame. */
class OneSurfaceMap : public Method
{
 public:
  explicit OneSurfaceMap(const Parameters& parameters) : parameters_(parameters) {}

 protected:
  struct Cell
  {
    /** NaN: unknown. */
    float height_m = std::numeric_limits<float>::quiet_NaN();
    float variance_m2 = std::numeric_limits<float>::quiet_NaN();
    double stamp_s = 0;  //!< of the last frame that changed the height

    bool known() const { return height_m == height_m; }
  };

  const Parameters& parameters() const { return parameters_; }
  RollingCells<Cell>& cells() { return cells_; }

  void roll_to(const Frame& frame)
  {
    cells_.move_to(
        window_around(parameters_, pose_of_base(frame.T_map_sensor, frame.T_base_sensor)));
  }

  /** Sensor noise of a point. */
  float point_variance_m2(const MapPoint& p) const
  {
    const auto deviation =
        static_cast<float>(parameters_.c_beam_m + parameters_.a_beam * p.range_m);
    return deviation * deviation;
  }

  /** Fuses a point that lies within the gate. */
  void kalman(Cell& c, const MapPoint& p, double stamp_s) const
  {
    const float variance = point_variance_m2(p);
    c.height_m = (variance * c.height_m + c.variance_m2 * p.z_m) / (variance + c.variance_m2);
    c.variance_m2 = std::max(
        variance * c.variance_m2 / (variance + c.variance_m2),
        static_cast<float>(parameters_.min_variance_m2));
    c.stamp_s = stamp_s;
  }

  /** Visibility cleanup: the ray to the lowest point of each cell that was hit bounds the heights
   * of all cells before it. What was not hit in this frame and stands higher is erased. */
  void clean_up(const Frame& frame, const std::vector<MapPoint>& points)
  {
    const std::vector<float> bound = ray_bounds(cells_.window(), frame.T_map_sensor, points);
    for (std::size_t i = 0; i < cells_.size(); ++i)
    {
      Cell& c = cells_[i];
      const float low = c.height_m - kCleanupDeviations * std::sqrt(c.variance_m2);
      if (c.stamp_s < frame.stamp_s && low > bound[i]) c = {};
    }
  }

  /** The heights, as elevation and as ground; not judged. */
  Surfaces surfaces() const
  {
    Surfaces s(cells_.window());
    for (std::size_t i = 0; i < cells_.size(); ++i)
    {
      if (!cells_[i].known()) continue;
      s.elevation_m[i] = s.ground_m[i] = cells_[i].height_m;
      s.state[i] = static_cast<std::uint8_t>(CellState::Measured);
    }
    return s;
  }

 private:
  Parameters parameters_;
  RollingCells<Cell> cells_;
};

/** A robot-centric elevation map with one surface, after Fankhauser et al. 2018: Kalman fusion
 * inside a Mahalanobis gate of 2.5; above it the point replaces the height, below it is ignored;
 * once a second a visibility cleanup walks the line to each cell and erases what stands above.
 * Traversability by judge_one_surface(). */
class HighestPointMap : public OneSurfaceMap
{
 public:
  using OneSurfaceMap::OneSurfaceMap;

  void update(const Frame& frame) override
  {
    const auto points = insert(frame);
    if (frame.stamp_s - last_cleanup_s_ < kCleanupPeriod_s) return;
    clean_up(frame, points);
    last_cleanup_s_ = frame.stamp_s;
  }

  Surfaces read() override
  {
    Surfaces s = surfaces();
    judge_one_surface(s, parameters());
    return s;
  }

 protected:
  /** Points of the frame, without the cleanup. Returns them. */
  std::vector<MapPoint> insert(const Frame& frame)
  {
    roll_to(frame);
    std::vector<MapPoint> points = accepted_points(frame, parameters());
    for (const MapPoint& p : points)
      if (Cell* c = cells().find(p.x_m, p.y_m)) fuse(*c, p, frame.stamp_s);
    return points;
  }

 private:
  void fuse(Cell& c, const MapPoint& p, double stamp_s) const
  {
    const float difference = p.z_m - c.height_m,
                gate_m = kGate_deviations * std::sqrt(c.variance_m2);
    if (!c.known() || difference > gate_m)
      c = {p.z_m, point_variance_m2(p), stamp_s};
    else if (difference >= -gate_m)
      kalman(c, p, stamp_s);
  }

  double last_cleanup_s_ = 0;
};

/** The same kind of map on a GPU, after Pan et al. 2019 (the paper's CuCpp): cleanup in every
 * frame; traversability half slope, half roughness, no step. */
class CuCppMap : public HighestPointMap
{
 public:
  using HighestPointMap::HighestPointMap;

  void update(const Frame& frame) override { clean_up(frame, insert(frame)); }

  Surfaces read() override
  {
    Surfaces s = surfaces();
    Parameters p = parameters();
    p.weight_slope = p.weight_roughness = 0.5;
    p.weight_step = 0;
    p.step_threshold_m = std::numeric_limits<double>::infinity();
    judge_one_surface(s, p);
    return s;
  }
};

/** A robot-centric elevation map with one surface, after Miki et al. 2022 (the paper's CuPy):
 * - points in a cone above the sensor are left out: what hangs there is passed below;
 * - drift compensation: the map follows the mean height error of the points on flat cells;
 * - Kalman fusion; a point outside the Mahalanobis gate makes the cell less sure instead, and so
 *   does time;
 * - visibility cleanup in every frame;
 * - gaps: the min filter, then inpainting (Telea) of what it left.
 * Traversability by judge_one_surface(), in place of its trained network. It does not say how far
 * a fill can be relied on: all count as filled from one side. */
class CuPyMap : public OneSurfaceMap
{
 public:
  using OneSurfaceMap::OneSurfaceMap;

  void update(const Frame& frame) override
  {
    roll_to(frame);
    std::vector<MapPoint> points = accepted_points(frame, parameters());
    const auto overhead = [&](const MapPoint& p) { return is_overhead(p, frame.T_map_sensor); };
    points.erase(std::remove_if(points.begin(), points.end(), overhead), points.end());
    grow_older(frame.stamp_s);
    compensate_drift(points);
    for (const MapPoint& p : points)
      if (Cell* c = cells().find(p.x_m, p.y_m)) fuse(*c, p, frame.stamp_s);
    clean_up(frame, points);
  }

  Surfaces read() override
  {
    Surfaces s = surfaces();
    const SparseGround near{s.window, fill_min_filter(measured_ground(s))};
    s.ground_m = s.elevation_m = fill_inpaint_telea(near);
    for (std::size_t i = 0; i < s.size(); ++i)
      if (s.known(i) && s.state[i] == static_cast<std::uint8_t>(CellState::Unknown))
        s.state[i] = static_cast<std::uint8_t>(CellState::FilledOneSided);
    judge_one_surface(s, parameters());
    return s;
  }

 private:
  void grow_older(double stamp_s)
  {
    const auto passed_s = static_cast<float>(std::max(stamp_s - last_stamp_s_, 0.0));
    for (Cell& c : cells()) c.variance_m2 += kTime_m2ps * passed_s;  // NaN stays
    last_stamp_s_ = stamp_s;
  }

  void compensate_drift(const std::vector<MapPoint>& points)
  {
    Surfaces s = surfaces();
    judge_one_surface(s, parameters());
    double sum_m = 0;
    int hits = 0;
    for (const MapPoint& p : points)
    {
      const int at = cell_index(s.window, p.x_m, p.y_m);
      if (at < 0) continue;
      const auto i = static_cast<std::size_t>(at);
      const Cell& c = cells()[i];
      if (!(c.variance_m2 < kTrusted_m2 && s.traversability[i] > kFlat)) continue;
      sum_m += static_cast<double>(p.z_m) - c.height_m;
      ++hits;
    }
    if (hits == 0 || std::abs(sum_m / hits) > kMaxDrift_m) return;
    for (Cell& c : cells()) c.height_m += static_cast<float>(kDriftShare * sum_m / hits);
  }

  void fuse(Cell& c, const MapPoint& p, double stamp_s) const
  {
    if (!c.known())
      c = {p.z_m, point_variance_m2(p), stamp_s};
    else if (std::abs(p.z_m - c.height_m) > kGate * std::sqrt(c.variance_m2))
      c.variance_m2 += kOutlier_m2;
    else
      kalman(c, p, stamp_s);
  }

  double last_stamp_s_ = 0;
};
}  // namespace

std::unique_ptr<Method> make_highest(const Parameters& parameters, Backend)
{
  return std::make_unique<HighestPointMap>(parameters);
}
std::unique_ptr<Method> make_cucpp(const Parameters& parameters, Backend)
{
  return std::make_unique<CuCppMap>(parameters);
}
std::unique_ptr<Method> make_cupy(const Parameters& parameters, Backend)
{
  return std::make_unique<CuPyMap>(parameters);
}

}  // namespace talus::baselines
