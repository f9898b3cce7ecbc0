#include <talus/calibrate/associate.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "plane_fit.h"

namespace talus::calibrate
{
namespace
{
constexpr std::size_t kFewPoints = 12;
constexpr int kFewFrames = 3;
constexpr double kSteepest = 1.0;  // dz per metre: 45 degrees
constexpr double kMinSpread = 0.1;  // of the points across a patch, of its size
constexpr double kSignificantF = 2.5;  // F of nine more parameters: chance is below 0.02

std::uint64_t cell_of(double x_m, double y_m, double cell_m)
{
  const auto index = [&](double v)
  {
    return static_cast<std::uint64_t>(
        static_cast<std::int64_t>(std::floor(v / cell_m)) + (1 << 30));
  };
  return index(y_m) << 32 | index(x_m);
}

Eigen::Vector2d center_of(std::uint64_t cell, double cell_m)
{
  const auto coordinate = [&](std::uint64_t i)
  { return (static_cast<double>(static_cast<std::int64_t>(i) - (1 << 30)) + 0.5) * cell_m; };
  return {coordinate(cell & 0xFFFFFFFFu), coordinate(cell >> 32)};
}

void sort_by_cell(std::vector<Hit>& hits)
{
  std::sort(
      hits.begin(), hits.end(),
      [](const Hit& a, const Hit& b)
      { return a.cell != b.cell ? a.cell < b.cell : a.point < b.point; });
}

std::vector<Hit> hits_of(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const AssociationOptions& o)
{
  Geometry g;
  evaluate_geometry(scans, track, v, g);
  const auto turns = half_turns(scans, track, v);
  std::vector<Hit> hits;
  hits.reserve(scans.points());
  for (std::size_t i = 0; i < g.views.size(); ++i)
  {
    const View& view = scans.views()[i];
    if (scans.held_out(view.frame) || !track.covers(view.time_s + v[kTimeOffset])) continue;
    const Eigen::Matrix3d R = g.views[i].R * g.mounting.R;
    const Eigen::Vector3d t = g.views[i].R * g.mounting.t_m + g.views[i].t_m;
    for (std::uint32_t k = view.first; k < view.first + view.count; ++k)
    {
      const Eigen::Vector3d p = scans.point(k);
      const double range = p.norm();
      if (range > o.max_range_m) continue;
      const Eigen::Vector3d q = R * p;
      Hit h;
      h.at_m = (q + t).cast<float>();
      h.on_ground_m = h.at_m.head<2>();
      h.cell = cell_of(h.at_m.x(), h.at_m.y(), o.cell_m);
      h.view = static_cast<std::uint32_t>(i);
      h.point = k;
      h.frame = view.frame;
      h.half_turn = static_cast<float>(turns[static_cast<std::size_t>(view.frame)]);
      h.beam = (q / range).cast<float>();
      h.range_m = static_cast<float>(range);
      hits.push_back(h);
    }
  }
  sort_by_cell(hits);
  return hits;
}

/** Calls `use(cell, points)` for each cell with enough points. */
template <typename Use>
void for_each_cell(const std::vector<Hit>& hits, Use use)
{
  Hits cell;
  for (std::size_t i = 0; i < hits.size(); ++i)
  {
    cell.push_back(&hits[i]);
    if (i + 1 < hits.size() && hits[i + 1].cell == hits[i].cell) continue;
    if (cell.size() >= kFewPoints) use(hits[i].cell, cell);
    cell.clear();
  }
}

/** Deals the points out again, by where their beams meet the ground of the cell they seem to be in.
 */
void deal_by_beam(const NoiseModel& noise, const AssociationOptions& o, std::vector<Hit>& hits)
{
  for_each_cell(
      hits,
      [&](std::uint64_t cell, const Hits& points)
      {
        const PlaneFit fit = fit_plane(points, center_of(cell, o.cell_m), noise);
        for (std::size_t i = 0; fit.solved && i < points.size(); ++i)
        {
          if (std::abs(fit.distance_m[i]) > o.gate * fit.sigma_m[i]) continue;
          Hit& h = hits[static_cast<std::size_t>(points[i] - hits.data())];
          h.on_ground_m = beam_on_plane(h, fit.distance_m[i], fit.plane).cast<float>();
        }
      });
  for (Hit& h : hits) h.cell = cell_of(h.on_ground_m.x(), h.on_ground_m.y(), o.cell_m);
  sort_by_cell(hits);
}

/** Collects the patches of one cell after the other. */
class Collector
{
 public:
  Collector(
      const NoiseModel& noise, const AssociationOptions& options,
      const std::vector<DrivenPlace>& driven, Association& out)
      : noise_(noise), options_(options), out_(out)
  {
    for (const auto& place : driven)
      driven_[cell_of(place.ground_m.x(), place.ground_m.y(), options.cell_m)].push_back(place);
  }

  void add_cell(std::uint64_t cell, const Hits& hits)
  {
    const auto found = driven_.find(cell);
    places_ = found == driven_.end() ? nullptr : &found->second;
    const Eigen::Vector2d center = center_of(cell, options_.cell_m);
    add(hits, center, options_.cell_m, fit_plane(hits, center, noise_));
  }

 private:
  void add(const Hits& hits, const Eigen::Vector2d& center_m, double size_m, const PlaneFit& fit);
  bool split(const Hits& hits, const Eigen::Vector2d& center_m, double size_m, const PlaneFit& fit);
  void keep(const Hits& hits, const Eigen::Vector2d& center_m, double size_m, const PlaneFit& fit);

  const NoiseModel& noise_;
  const AssociationOptions& options_;
  std::map<std::uint64_t, std::vector<DrivenPlace>> driven_;
  const std::vector<DrivenPlace>* places_ = nullptr;
  Association& out_;
};

void Collector::add(
    const Hits& hits, const Eigen::Vector2d& center_m, double size_m, const PlaneFit& fit)
{
  if (!fit.solved || split(hits, center_m, size_m, fit)) return;
  keep(hits, center_m, size_m, fit);
}

/** Whether four planes fit significantly better than one (F test); then they are added instead. */
bool Collector::split(
    const Hits& hits, const Eigen::Vector2d& center_m, double size_m, const PlaneFit& fit)
{
  if (size_m / 2 < options_.least_cell_m * 0.999 || hits.size() < 4 * kFewPoints) return false;
  struct Quarter
  {
    Hits hits;
    Eigen::Vector2d center_m;
    double squares_before = 0;
    PlaneFit fit;
  };
  std::array<Quarter, 4> quarters;
  for (std::size_t i = 0; i < hits.size(); ++i)
  {
    Eigen::Vector2d at = hits[i]->on_ground_m.cast<double>() - center_m;
    if (noise_.along_beam) at = beam_on_plane(*hits[i], fit.distance_m[i], fit.plane) - center_m;
    auto& q = quarters[(at.x() >= 0 ? 1 : 0) + (at.y() >= 0 ? 2 : 0)];
    q.hits.push_back(hits[i]);
    q.squares_before += robust_squares(fit.distance_m[i], fit.sigma_m[i]);
  }
  double before = 0, after = 0;
  int planes = 0;
  std::size_t points = 0;
  for (std::size_t k = 0; k < 4; ++k)
  {
    Quarter& q = quarters[k];
    q.center_m = center_m + size_m / 4 * Eigen::Vector2d(k & 1 ? 1 : -1, k & 2 ? 1 : -1);
    if (q.hits.size() < kFewPoints) continue;
    q.fit = fit_plane(q.hits, q.center_m, noise_);
    if (!q.fit.solved) continue;
    before += q.squares_before;
    after += q.fit.weighted_squares;
    points += q.hits.size();
    ++planes;
  }
  const double freedom = static_cast<double>(points) - 3.0 * planes;
  if (planes < 2 || freedom < 1) return false;
  const double F = (before - after) / (3.0 * planes - 3) / (after / freedom);
  if (!(F > kSignificantF)) return false;
  for (const Quarter& q : quarters) add(q.hits, q.center_m, size_m / 2, q.fit);
  return true;
}

void Collector::keep(
    const Hits& hits, const Eigen::Vector2d& center_m, double size_m, const PlaneFit& fit)
{
  if (fit.plane.tail<2>().norm() > kSteepest) return;
  Hits near;
  std::vector<int> frames;
  std::vector<Sample> samples;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < hits.size(); ++i)
  {
    if (std::abs(fit.distance_m[i]) > options_.gate * fit.sigma_m[i]) continue;
    const Hit& h = *hits[i];
    samples.push_back({h.view, h.point, h.range_m, fit.cosine[i], fit.sigma_m[i]});
    frames.push_back(h.frame);
    const Eigen::Vector2d at = h.offset(center_m);
    mean += at;
    squares += at * at.transpose();
  }
  const auto n = static_cast<double>(samples.size());
  if (samples.size() < kFewPoints || n < options_.inlier_share * static_cast<double>(hits.size()))
    return;
  const Eigen::Matrix2d spread = squares / n - mean * mean.transpose() / (n * n);
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvalues()[0];
  if (!(least > std::pow(kMinSpread * size_m, 2))) return;
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  if (static_cast<int>(frames.size()) < kFewFrames) return;

  Patch patch;
  patch.center_m = center_m;
  patch.size_m = size_m;
  patch.plane = fit.plane;
  patch.frames = static_cast<int>(frames.size());
  patch.first = static_cast<std::uint32_t>(out_.samples.size());
  const double share = options_.most_per_patch / n;
  for (const Sample& s : samples)
    if (chance(s.point, 1) < share) out_.samples.push_back(s);
  patch.count = static_cast<std::uint32_t>(out_.samples.size()) - patch.first;
  if (places_) patch.contact = contact_in(*places_, center_m, size_m);
  out_.patches.push_back(patch);
}

/** Leaves out whole patches, so that those that stay are as well covered as before; driven ones are
 * few and stay. */
void thin_patches(std::size_t most_samples, Association& a)
{
  if (a.samples.size() <= most_samples) return;
  const double share = static_cast<double>(most_samples) / static_cast<double>(a.samples.size());
  Association kept;
  kept.scatter = a.scatter;
  kept.along_beam = a.along_beam;
  for (Patch p : a.patches)
  {
    const auto place = cell_of(p.center_m.x(), p.center_m.y(), 0.01);
    if (!p.contact && chance(place, 2) >= share) continue;
    const auto begin = a.samples.begin() + p.first;
    p.first = static_cast<std::uint32_t>(kept.samples.size());
    kept.samples.insert(kept.samples.end(), begin, begin + p.count);
    kept.patches.push_back(p);
  }
  a = std::move(kept);
}
}  // namespace

std::vector<double> half_turns(const ScanSet& scans, const PoseTrack& track, const Vector& v)
{
  const MountingPose m = mounting_pose(v);
  std::vector<double> turns;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (int f = 0; f < scans.frames(); ++f)
  {
    const Eigen::Vector3d axis = track.at(scans.stamp_s(f) + v[kTimeOffset]).R * m.R.col(2);
    const double cosine = f == 0 ? 1.0 : std::min(1.0, axis.dot(last));
    turns.push_back(std::sqrt((1 - cosine) / 2));
    last = axis;
  }
  return turns;
}

Association associate(
    const ScanSet& scans, const PoseTrack& track, const std::vector<DrivenPlace>& driven,
    const Vector& v, const NoiseModel& noise, const AssociationOptions& options)
{
  std::vector<Hit> hits = hits_of(scans, track, v, options);
  if (noise.along_beam) deal_by_beam(noise, options, hits);
  Association a;
  a.along_beam = noise.along_beam;
  Collector collector(noise, options, driven, a);
  for_each_cell(
      hits, [&](std::uint64_t cell, const Hits& points) { collector.add_cell(cell, points); });
  a.scatter = scatter_of(a.patches);
  thin_patches(options.most_samples, a);
  return a;
}

}  // namespace talus::calibrate
