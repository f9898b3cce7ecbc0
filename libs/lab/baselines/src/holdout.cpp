#include <talus/baselines/real_log.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

namespace talus::baselines
{
namespace
{
constexpr int kEvery = 4, kBands = 64, kFirstFrame = 3;

/** What is sure to be ground, see HoldOut: chosen on half of the labelled scans at hand,
 * where steeper cones keep more points that are not ground, and flatter ones lose ground. */
constexpr double kGroundSlope = 0.3, kGroundAllowance_m = 0.1, kGroundRadius_m = 3.0;
constexpr float kBare_m = 0.3f;

/** A scan in two parts. */
struct SplitScan
{
  ScanFrame kept, held;
};

float elevation_angle(const ScanFrame& f, std::size_t i)
{
  return std::atan2(f.z_m[i], std::hypot(f.x_m[i], f.y_m[i]));
}

void push(ScanFrame& to, const ScanFrame& from, std::size_t i)
{
  to.x_m.push_back(from.x_m[i]);
  to.y_m.push_back(from.y_m[i]);
  to.z_m.push_back(from.z_m[i]);
}

/** Bands of equal elevation angle between the 1st and the 99th percentile. */
class Bands
{
 public:
  explicit Bands(const ScanFrame& scan)
  {
    std::vector<float> angles;
    for (std::size_t i = 0; i < scan.x_m.size(); ++i)
      if (const float a = elevation_angle(scan, i); std::isfinite(a)) angles.push_back(a);
    if (angles.empty()) return;
    std::sort(angles.begin(), angles.end());
    const std::size_t tail = angles.size() / 100;
    low_ = angles[tail];
    width_ = std::max((angles[angles.size() - 1 - tail] - low_) / kBands, 1e-6f);
    choose(angles);
  }

  bool held(float angle) const
  {
    const int b = band(angle);
    return b >= 0 && held_[b];
  }

 private:
  /** -1: outside. */
  int band(float angle) const
  {
    const float b = std::floor((angle - low_) / width_);
    return b >= 0 && b < static_cast<float>(held_.size()) ? static_cast<int>(b) : -1;
  }

  /** Every n-th band that has points is held out. */
  void choose(const std::vector<float>& angles)
  {
    held_.assign(kBands, 0);
    std::vector<int> points(held_.size(), 0);
    for (float a : angles)
      if (const int b = band(a); b >= 0) ++points[b];
    int rank = 0;
    for (std::size_t b = 0; b < held_.size(); ++b)
      if (points[b] > 0) held_[b] = rank++ % kEvery == kEvery / 2;
  }

  float low_ = 0, width_ = 1;
  std::vector<std::uint8_t> held_;
};

SplitScan split(const ScanFrame& scan)
{
  SplitScan out{scan, scan};
  for (ScanFrame* part : {&out.kept, &out.held})
    for (auto* v : {&part->x_m, &part->y_m, &part->z_m}) v->clear();
  const Bands bands(scan);
  for (std::size_t i = 0; i < scan.x_m.size(); ++i)
    push(bands.held(elevation_angle(scan, i)) ? out.held : out.kept, scan, i);
  return out;
}

/** What all beams of all frames of a log hit in the cells of a window. NaN: nothing. */
struct SeenCells
{
  /** Where the ground lies at most: the second lowest of what the frames saw, since single
   * reflections come from below the ground. */
  std::vector<float> ground_m;
  std::vector<float> highest_m;
};

class SeenByLog
{
 public:
  void add(const ScanFrame& scan, const Parameters& parameters)
  {
    std::unordered_map<std::uint64_t, Extent> of_scan;
    for (const MapPoint& p : accepted_points(scan.view(), parameters))
      of_scan[key(std::floor(p.x_m / parameters.resolution_m),
                  std::floor(p.y_m / parameters.resolution_m))]
          .add(p.z_m, p.z_m);
    for (const auto& [cell, seen] : of_scan) cells_[cell].add(seen.lowest_m, seen.highest_m);
  }

  SeenCells in(const Window& w) const
  {
    SeenCells seen;
    for (int y = 0; y < w.cells; ++y)
      for (int x = 0; x < w.cells; ++x)
      {
        const auto at = cells_.find(
            key(static_cast<double>(w.min_cell_x + x), static_cast<double>(w.min_cell_y + y)));
        const bool hit = at != cells_.end();
        seen.ground_m.push_back(hit ? at->second.ground_m() : NAN);
        seen.highest_m.push_back(hit ? at->second.highest_m : NAN);
      }
    return seen;
  }

 private:
  struct Extent
  {
    float lowest_m = std::numeric_limits<float>::infinity(), second_lowest_m = lowest_m;
    float highest_m = -lowest_m;
    void add(float low_m, float high_m)
    {
      second_lowest_m = std::min(second_lowest_m, std::max(lowest_m, low_m));
      lowest_m = std::min(lowest_m, low_m);
      highest_m = std::max(highest_m, high_m);
    }
    float ground_m() const { return std::isinf(second_lowest_m) ? lowest_m : second_lowest_m; }
  };
  static std::uint64_t key(double ix, double iy)
  {
    const auto word = [](double i)
    { return static_cast<std::uint32_t>(static_cast<std::int64_t>(i)); };
    return static_cast<std::uint64_t>(word(ix)) << 32 | word(iy);
  }
  std::unordered_map<std::uint64_t, Extent> cells_;
};

/** Whether a point is ground: nothing stands on it or lies below the cone under it. */
bool is_ground(const SeenCells& seen, const Window& w, std::size_t k, float z_m)
{
  if (seen.highest_m[k] - z_m > kBare_m) return false;
  const int radius = static_cast<int>(kGroundRadius_m / w.resolution_m);
  const int ix = static_cast<int>(k) % w.cells, iy = static_cast<int>(k) / w.cells;
  for (int y = std::max(iy - radius, 0); y <= std::min(iy + radius, w.cells - 1); ++y)
    for (int x = std::max(ix - radius, 0); x <= std::min(ix + radius, w.cells - 1); ++x)
    {
      const double distance_m = std::hypot(x - ix, y - iy) * w.resolution_m;
      if (seen.ground_m[y * w.cells + x] < z_m - kGroundAllowance_m - kGroundSlope * distance_m)
        return false;
    }
  return true;
}

Fills all_fills(const Surfaces& map)
{
  const SparseGround sparse = measured_ground(map);
  Fills fills{{"talus", map.ground_m}};
  for (const FillMethod& m : fill_methods()) fills.emplace_back(m.name, m.fill(sparse));
  return fills;
}

/** What a frame is scored with. */
struct Held
{
  const Surfaces& map;  //!< of the beams that were kept
  const SeenCells& seen;
  const Parameters& parameters;
  const LabelMap* labels;  //!< nullptr: none

  bool is_ground(std::size_t k, float z_m) const
  {
    return baselines::is_ground(seen, map.window, k, z_m);
  }
  GroundTruth label(std::size_t k, float z_m) const
  {
    const auto [x_m, y_m] = middle_of_cell(map.window, k);
    return labels->truth_of(x_m, y_m, z_m);
  }
};

void score_cell(HoldOut& out, const Fills& fills, const Held& held, std::size_t k, float z_m)
{
  const Surfaces& map = held.map;
  for (std::size_t f = 0; f < fills.size(); ++f)
    out.fills[f].coverage.add(!std::isnan(fills[f].second[k]));
  for (const auto& fill : fills)
    if (std::isnan(fill.second[k])) return;
  if (held.labels && held.label(k, z_m) != GroundTruth::NotScored)
    out.not_ground.add(held.label(k, z_m) == GroundTruth::Other);
  const bool two_sided = static_cast<CellState>(map.state[k]) == CellState::FilledTwoSided;
  for (std::size_t f = 0; f < fills.size(); ++f)
  {
    const float error = fills[f].second[k] - z_m;
    out.fills[f].all.add(error);
    (two_sided ? out.fills[f].two_sided : out.fills[f].one_sided).add(error);
  }
}

/** Cells within two of something that stands on the ground. */
std::vector<std::uint8_t> beside_objects(const Surfaces& map, double step_m)
{
  const int n = map.window.cells;
  cv::Mat stands(n, n, CV_8U);
  for (int k = 0; k < n * n; ++k)
  {
    const auto at = static_cast<std::size_t>(k);
    stands.at<std::uint8_t>(k / n, k % n) =
        static_cast<double>(map.elevation_m[at] - map.ground_m[at]) > step_m / 2;
  }
  cv::dilate(stands, stands, cv::Mat::ones(5, 5, CV_8U));
  return {stands.begin<std::uint8_t>(), stands.end<std::uint8_t>()};
}

void score_fills(HoldOut& out, const Held& held, const std::vector<float>& lowest_m)
{
  const Fills fills = all_fills(held.map);
  for (std::size_t f = 0; f < fills.size(); ++f) out.fills[f].fill = fills[f].first;
  for (std::size_t k = 0; k < lowest_m.size(); ++k)
  {
    const auto state = static_cast<CellState>(held.map.state[k]);
    if (!std::isnan(lowest_m[k]) && state != CellState::Measured && state != CellState::Presumed &&
        held.is_ground(k, lowest_m[k]))
      score_cell(out, fills, held, k, lowest_m[k]);
  }
}

/** Compares the heights with those of the map of the held-out beams. */
void score_bars(HoldOut& out, const Held& held, const Surfaces& other)
{
  const double step_m = held.parameters.step_threshold_m;
  const auto beside = beside_objects(held.map, step_m),
             beside_other = beside_objects(other, step_m);
  for (std::size_t k = 0; k < other.size(); ++k)
    if (static_cast<CellState>(other.state[k]) == CellState::Measured && !beside[k] &&
        !beside_other[k] && held.is_ground(k, other.ground_m[k]))
      out.bars.add(held.map, k, held.map.ground_m[k] - other.ground_m[k], other.variance_m2[k]);
}

}  // namespace

HoldOut hold_out(const Sequence& sequence, const EvaluationOptions& options, const LabelMap* labels)
{
  HoldOut out;
  out.name = sequence.name;
  out.sensor = sequence.sensor;
  out.frames = static_cast<int>(sequence.frames.size());
  out.fills.resize(fill_methods().size() + 1);
  const auto map = make_method("talus", options.parameters, options.backend);
  const auto other = make_method("talus", options.parameters, options.backend);
  const int first = std::min(kFirstFrame, out.frames - 1);
  SeenByLog seen;
  for (const ScanFrame& scan : sequence.frames) seen.add(scan, options.parameters);
  for (int i = 0; i < out.frames; ++i)
  {
    const ScanFrame& scan = sequence.frames[i];
    const SplitScan parts = split(scan);
    map->update(parts.kept.view());
    other->update(parts.held.view());
    if (options.progress) options.progress("held-out beams", i + 1, out.frames);
    if (i < first) continue;
    const Surfaces surfaces = map->read();
    const SeenCells all = seen.in(surfaces.window);
    const Held held{surfaces, all, options.parameters, labels};
    score_fills(
        out, held,
        lowest_points(accepted_points(parts.held.view(), options.parameters), surfaces.window));
    score_bars(out, held, other->read());
  }
  return out;
}

}  // namespace talus::baselines
