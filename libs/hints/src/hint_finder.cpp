#include <talus/hints/hint_finder.h>

#include <algorithm>
#include <cmath>

#include "near_ground.h"
#include "figures.h"
#include "judge.h"
#include "thresholds.h"

namespace talus::hints
{
namespace
{
/** The first frames, then fewer and fewer: what is wrong shows soon. */
bool is_due(std::size_t frame)
{
  const std::size_t step = frame < kManyFrames ? 4 : frame < kSomeFrames ? 8 : 32;
  return frame < kAllFrames || frame % step == 0;
}

bool is_identity(const Pose& T)
{
  const Pose none;
  return T.m == none.m;
}

double tilt_rad(const Pose& T) { return std::acos(std::clamp(T.m[10], -1.0, 1.0)); }

/** A ceiling as high above the sensor as the ground should be below it is no ceiling. */
void note_plane(SensorFigures& s, const std::vector<Vec3>& points, const NearPlane& lowest)
{
  if (lowest.found)
  {
    s.normal_x.add(lowest.normal.x);
    s.normal_y.add(lowest.normal.y);
    s.ground_m.add(lowest.height_at_base_m());
    s.sensor_above_m.add(lowest.distance_m(s.sensor));
    s.rms_m.add(lowest.rms_m);
  }
  const bool is_near_base = lowest.found && std::abs(lowest.height_at_base_m()) < kWrongHeight_m;
  if (is_near_base) return;
  const NearPlane highest = lowest_plane(points, s.sensor, -1);
  if (highest.found) s.ceiling_above_m.add(highest.distance_m(s.sensor));
  if (lowest.found || highest.found) return;
  const NearPlane steep = supporting_plane(points, s.sensor);
  if (steep.found) s.steep_rad.add(std::acos(std::clamp(std::abs(steep.normal.z), 0.0, 1.0)));
}

/** How far from the sensor the ground is seen, and how near. */
void note_reach(SensorFigures& s, const std::vector<Vec3>& points, const NearPlane& ground)
{
  Values distances, on_it;
  for (const Vec3& p : points)
  {
    const double off_m = std::abs(ground.distance_m(p));
    const double r_m = away_m(p, s.sensor);
    if (off_m < kGroundBand_m) distances.add(r_m);
    if (off_m < kOnGround_m) on_it.add(r_m);
  }
  if (on_it.size() > 0) s.nearest_m.add(on_it.quantile(kHardlyAny));
  if (distances.size() > 0) s.reach_m.add(distances.quantile(0.9));
}

/** Of a ray straight ahead, as a beam sends it that turns around `axis` at an angle of this sine.
 */
double slope_ahead(const Vec3& axis, double sine)
{
  const double cosine = std::sqrt(std::max(0.0, 1 - sine * sine));
  const double across = std::max(1e-6, std::hypot(axis.y, axis.z));
  const Vec3 ahead{across, -axis.x * axis.y / across, -axis.x * axis.z / across};
  const double z = cosine * ahead.z + sine * axis.z;
  return z / std::hypot(cosine * ahead.x + sine * axis.x, cosine * ahead.y + sine * axis.y);
}

/** How steep the highest ray ahead is, as far as rays returned: those ahead, and those of a beam
 * that turns and returned from elsewhere. And the highest to any side. */
void note_top(SensorFigures& s, const std::vector<Vec3>& points, const Vec3& axis)
{
  double ahead = -HUGE_VAL, around = -HUGE_VAL, sine = -1;
  for (const Vec3& p : points)
  {
    const Vec3 d = p - s.sensor;
    const double r_m = away_m(p, s.sensor);
    if (r_m < kNear_m) continue;
    around = std::max(around, d.z / r_m);
    sine = std::max(sine, dot(d, axis) / length(d));
    if (d.x > kAheadCosine * r_m) ahead = std::max(ahead, d.z / r_m);
  }
  if (ahead == -HUGE_VAL) return;
  s.top_ahead.add(std::max(ahead, slope_ahead(axis, sine)));
  s.top_around.add(around);
}

/** Keeps every n-th of too many. */
void thin_out(std::vector<Vec3>& points, std::size_t most)
{
  const std::size_t step = points.size() / most + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); i += step) points[kept++] = points[i];
  points.resize(kept);
}
}  // namespace

struct HintFinder::Scratch
{
  std::vector<Vec3> points, near;
  std::vector<float> times_s;  //!< of the points
};

HintFinder::HintFinder(const Parameters& parameters, Effort effort)
    : parameters_(parameters),
      effort_(effort),
      figures_(std::make_unique<Figures>()),
      scratch_(std::make_unique<Scratch>())
{
}
HintFinder::~HintFinder() = default;
HintFinder::HintFinder(HintFinder&&) noexcept = default;
HintFinder& HintFinder::operator=(HintFinder&&) noexcept = default;

std::size_t HintFinder::frames() const { return figures_->frames; }

std::size_t HintFinder::number_of(const std::string& label)
{
  auto& sensors = figures_->sensors;
  const auto known =
      std::find_if(sensors.begin(), sensors.end(), [&](const auto& s) { return s.label == label; });
  if (known != sensors.end()) return static_cast<std::size_t>(known - sensors.begin());
  sensors.emplace_back();
  sensors.back().label = label;
  return sensors.size() - 1;
}

void HintFinder::add(const Frame& frame, const std::string& sensor, const FrameReport& report)
{
  Figures& f = *figures_;
  ++f.frames;
  f.points_in += report.points_in;
  f.accepted += report.points_accepted;
  for (std::size_t i = 0; i < f.rejected.size(); ++i) f.rejected[i] += report.rejected[i];
  const Pose T_map_base = pose_of_base(frame.T_map_sensor, frame.T_base_sensor);
  f.poses.add(frame.stamp_s, T_map_base);
  f.level.add(T_map_base);
  const std::size_t number = number_of(sensor);
  SensorFigures& s = f.sensors[number];
  if (s.frames == 0)
  {
    s.mount_tilt_rad = tilt_rad(frame.T_base_sensor.value_or(Pose{}));
    s.first_tilt_rad = tilt_rad(frame.T_map_sensor);
  }
  look_at_walls(frame, number, T_map_base);
  const bool due = is_due(s.frames++);
  if (due || effort_ == Effort::Much) look_at(frame, number);
}

void HintFinder::look_at(const Frame& frame, std::size_t sensor)
{
  Figures& f = *figures_;
  SensorFigures& s = f.sensors[sensor];
  const Pose T_map_base = pose_of_base(frame.T_map_sensor, frame.T_base_sensor);
  const Pose T_base_sensor = frame.T_base_sensor.value_or(Pose{});
  s.has_mounting = !is_identity(T_base_sensor);
  s.sensor = origin_of(T_base_sensor);
  auto& points = scratch_->points;
  const bool thorough = effort_ == Effort::Much;
  sample_in_base(frame, parameters_, thorough ? kManyPoints : kFewPoints, s.frames, points);
  if (is_flat_scan(points, s.sensor)) return;
  ++s.analysed;
  f.base_up.add(T_map_base.m[10]);
  f.sampled += points.size();
  for (const Vec3& p : points)
  {
    const double rise_m = turned(T_map_base, p - s.sensor).z;
    f.below_band += rise_m < parameters_.min_height_m;
    f.above_band += rise_m > parameters_.max_height_m;
  }
  note_top(s, points, turned(T_base_sensor, {0, 0, 1}));
  const NearPlane lowest = lowest_plane(points, s.sensor, 1);
  note_plane(s, points, lowest);
  if (lowest.found)
  {
    const Vec3 normal_map = turned(T_map_base, lowest.normal);
    s.lean_in_map_rad.add(std::acos(std::clamp(normal_map.z, -1.0, 1.0)));
    f.level.add_ground(normal_map);
    note_reach(s, points, lowest);
    if (const auto share = buried_share(points, lowest, s.sensor)) s.buried.add(*share);
    f.ground.add(points, lowest, T_map_base);
  }
  else if (const NearPlane farther = lowest_plane(points, s.sensor, 1, kFarther_m, kFartherShare);
           farther.found)
  {
    s.above_far_ground_m.add(farther.distance_m(s.sensor));
    note_reach(s, points, farther);
  }
  watch_body(frame, sensor, lowest, T_map_base);
  if (thorough && lowest.found && s.analysed <= kNoiseFrames)
  {
    near_in_base(frame, parameters_, kFar_m, scratch_->near);
    note_spreads(scratch_->near, lowest, s.spread_m);
  }
}

void HintFinder::look_at_walls(const Frame& frame, std::size_t sensor, const Pose& T_map_base)
{
  SensorFigures& s = figures_->sensors[sensor];
  s.is_deskewed |= !frame.path.empty();
  const bool for_lag = s.lag.wants(frame.stamp_s, T_map_base);
  const bool for_axes = s.axes.wants(frame.stamp_s, T_map_base);
  if (!for_lag && !for_axes) return;
  const Vec3 at = origin_of(frame.T_base_sensor.value_or(Pose{}));
  const NearPlane level;  // the base is on the ground
  sample_in_base(frame, parameters_, kWallPoints, s.frames, scratch_->points, &scratch_->times_s);
  const auto facets =
      facets_of(scratch_->points, scratch_->times_s, level, at, T_map_base, kFacets);
  if (for_lag) s.lag.add(facets);
  if (for_axes) s.axes.add(facets);
}

void HintFinder::watch_body(
    const Frame& frame, std::size_t sensor, const NearPlane& lowest, const Pose& T_map_base)
{
  BodyWatch& body = figures_->sensors[sensor].body;
  if (!body.wants(T_map_base)) return;
  auto& near = scratch_->near;
  near_in_base(frame, parameters_, kBodyReach_m, near);
  const NearPlane ground = lowest.found ? lowest : NearPlane{};  // else level, at the base
  body.add_ground(near, ground, figures_->sensors[sensor].sensor);
  near.erase(
      std::remove_if(
          near.begin(), near.end(),
          [&](const Vec3& p) { return ground.distance_m(p) < kBodyAbove_m / 2; }),
      near.end());
  if (effort_ == Effort::Little) thin_out(near, kMaxNearPoints);
  body.add(near, scratch_->points, T_map_base);
}

std::vector<Hint> HintFinder::find(double known_share) const
{
  return judge(*figures_, parameters_, known_share);
}

}  // namespace talus::hints
