#include <talus/site/site_mapper.h>
#include <talus/baselines/real_log.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace talus::baselines
{
namespace
{
/** What stands so high stops a robot, and what is higher hangs over it. */
constexpr float kLowest_m = 0.3f, kHighest_m = 1.8f;
constexpr int kLeftFrames = 5;  //!< with ground alone, after which what stood there has left

/** What all frames of a log hit, cell by cell. */
class CellHits
{
 public:
  /** Two passes: what stands is found by the lowest of all. */
  CellHits(const Sequence& sequence, const Parameters& p);

  /** -infinity: nothing was hit. */
  float highest_m(double x_m, double y_m) const;
  /** Whether what stood in a cell was not there in the last frames that hit it. */
  bool has_left(double x_m, double y_m) const;

 private:
  struct Hits
  {
    float lowest_m = std::numeric_limits<float>::infinity();
    float highest_m = -std::numeric_limits<float>::infinity();
    bool stood = false;  //!< something, in any frame
    int bare_after = 0;  //!< frames with ground alone since then
  };
  using Key = std::pair<std::int64_t, std::int64_t>;
  Key key(double x_m, double y_m) const;
  const Hits* find(const Key& cell) const;
  void add(const std::vector<MapPoint>& points);

  double resolution_m_;
  std::map<Key, Hits> hits_;
};

CellHits::CellHits(const Sequence& sequence, const Parameters& p) : resolution_m_(p.resolution_m)
{
  for (const ScanFrame& frame : sequence.frames)
    for (const MapPoint& point : accepted_points(frame.view(), p))
    {
      Hits& h = hits_[key(point.x_m, point.y_m)];
      h.lowest_m = std::min(h.lowest_m, point.z_m);
      h.highest_m = std::max(h.highest_m, point.z_m);
    }
  for (const ScanFrame& frame : sequence.frames) add(accepted_points(frame.view(), p));
}

float CellHits::highest_m(double x_m, double y_m) const
{
  const Hits* const h = find(key(x_m, y_m));
  return h ? h->highest_m : Hits{}.highest_m;
}

bool CellHits::has_left(double x_m, double y_m) const
{
  const Hits* const h = find(key(x_m, y_m));
  return h && h->stood && h->bare_after >= kLeftFrames;
}

CellHits::Key CellHits::key(double x_m, double y_m) const
{
  const auto cell = [&](double at_m)
  { return static_cast<std::int64_t>(std::floor(at_m / resolution_m_)); };
  return {cell(x_m), cell(y_m)};
}

const CellHits::Hits* CellHits::find(const Key& cell) const
{
  const auto found = hits_.find(cell);
  return found == hits_.end() ? nullptr : &found->second;
}

void CellHits::add(const std::vector<MapPoint>& points)
{
  std::map<Key, bool> up;
  for (const MapPoint& p : points)
  {
    const float above_m = p.z_m - hits_[key(p.x_m, p.y_m)].lowest_m;
    up[key(p.x_m, p.y_m)] |= above_m >= kLowest_m && above_m <= kHighest_m;
  }
  for (const auto& [cell, stands] : up)
  {
    Hits& h = hits_[cell];
    h.stood |= stands;
    h.bare_after = stands ? 0 : h.bare_after + 1;
  }
}

constexpr std::size_t kMemory_bytes = std::size_t{512} << 20;

/** Drives once more, and keeps what leaves the window. */
void keep_drive(site::Site& site, const Sequence& sequence, const Parameters& parameters)
{
  site::SiteMapper mapper(site);
  ElevationMapper map(parameters, Backend::Cpu, 1);
  for (const ScanFrame& frame : sequence.frames) mapper.update(map, frame.view());
  mapper.keep_window(map);
  mapper.look_back(map);
}

/** Of the cells of the site of the whole drive that are labelled kMoves: blocked. Throws
 * std::runtime_error as TileStore. */
Share swept_blocked(const Sequence& sequence, const LabelMap& labels, const Parameters& parameters)
{
  Share blocked;
  const auto& all = *labels.stack.find("label");
  if (std::find(all.begin(), all.end(), static_cast<float>(LabelMap::kMoves)) == all.end())
    return blocked;
  site::Site site(
      parameters.resolution_m, kMemory_bytes, std::filesystem::temp_directory_path().string());
  keep_drive(site, sequence, parameters);
  const auto label_of = [&](std::int64_t x, std::int64_t y)
  {
    const auto middle_m = [&](std::int64_t cell)
    { return site::middle_of_cell_m(cell, parameters.resolution_m); };
    const std::ptrdiff_t at = labels.cell_at(middle_m(x), middle_m(y));
    return at < 0 ? LabelMap::kNotKnown : labels.label(at);
  };
  for (const site::TileKey& key : site.tiles.keys())
  {
    const auto& cells = site.tiles.find(key)->cells;
    for (std::size_t i = 0; i < cells.size(); ++i)
    {
      const auto at = static_cast<std::int64_t>(i);
      const std::int64_t x = site::cell_of_tile(key.x, at % site::kTileCells);
      const std::int64_t y = site::cell_of_tile(key.y, at / site::kTileCells);
      if (cells[i].known() && label_of(x, y) == LabelMap::kMoves)
        blocked.add(cells[i].cell.traversability == 0);
    }
  }
  return blocked;
}

constexpr float kOnGround_m = 0.15f;

void score_points(
    const std::vector<MapPoint>& points, const LabelMap& labels, const Surfaces& map,
    RealLogScore& score)
{
  for (const MapPoint& p : points)
  {
    const GroundTruth truth = labels.truth_of(p.x_m, p.y_m, p.z_m);
    const int k = cell_index(map.window, p.x_m, p.y_m);
    if (k < 0 || truth == GroundTruth::NotScored) continue;
    const bool is_ground = truth == GroundTruth::Ground;
    const bool is_said = std::abs(p.z_m - map.ground_m[k]) <= kOnGround_m;
    if (is_said) score.precision.add(is_ground);
    if (is_ground) score.recall.add(is_said);
  }
}

bool touches_obstacle(const LabelMap& labels, double x_m, double y_m, double step_m)
{
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
    {
      const std::ptrdiff_t at = labels.cell_at(x_m + dx * step_m, y_m + dy * step_m);
      if (at >= 0 && labels.label(at) >= LabelMap::kObstacle) return true;
    }
  return false;
}

/** Mean height of the ground labelled nearest to a cell, NaN: none within a metre. */
float local_ground_m(const LabelMap& labels, double x_m, double y_m)
{
  const int rings = static_cast<int>(1.0 / labels.stack.resolution_m);
  for (int ring = 0; ring <= rings; ++ring)
  {
    Share ground;
    for (int dy = -ring; dy <= ring; ++dy)
      for (int dx = -ring; dx <= ring; ++dx)
      {
        const double step_m = labels.stack.resolution_m;
        const std::ptrdiff_t at = labels.cell_at(x_m + dx * step_m, y_m + dy * step_m);
        if (at < 0 || std::isnan(labels.ground_m(at))) continue;
        ground.part += labels.ground_m(at), ground.of += 1;
      }
    if (ground.of > 0) return static_cast<float>(ground.value());
  }
  return NAN;
}

void score_labels(
    const LabelMap& labels, const CellHits& hits, const Surfaces& map, double step_threshold_m,
    RealLogScore& score)
{
  for (std::size_t k = 0; k < map.size(); ++k)
  {
    const auto [x_m, y_m] = middle_of_cell(map.window, k);
    const std::ptrdiff_t at = labels.cell_at(x_m, y_m);
    const int label = at < 0 ? LabelMap::kNotKnown : labels.label(at);
    if (label == LabelMap::kObstacle) score.obstacle_blocked.add(map.blocked(k));
    if (label == LabelMap::kLow &&
        hits.highest_m(x_m, y_m) - local_ground_m(labels, x_m, y_m) > step_threshold_m)
      score.low_blocked.add(map.blocked(k));
    if (label == LabelMap::kMoves && hits.has_left(x_m, y_m))
      score.left_blocked.add(map.blocked(k));
    if (label == LabelMap::kGround && !touches_obstacle(labels, x_m, y_m, map.window.resolution_m))
      score.ground_passable.add(map.passable(k));
  }
}

void score_window(const Surfaces& map, RealLogScore& score)
{
  for (std::size_t k = 0; k < map.size(); ++k)
  {
    const bool judged = map.blocked(k) || map.passable(k);
    if (map.known(k)) score.unjudged.add(!judged);
    if (static_cast<CellState>(map.state[k]) == CellState::FilledTwoSided)
      score.two_sided_unjudged.add(!judged);
  }
}

}  // namespace

bool LabelMap::is_one(const io::LayerStack& stack)
{
  return stack.find("ground") && stack.find("label") && !stack.find("obstacle_top");
}

std::ptrdiff_t LabelMap::cell_at(double x_m, double y_m) const
{
  const double x = std::floor((x_m - stack.min_x_m) / stack.resolution_m);
  const double y = std::floor((y_m - stack.min_y_m) / stack.resolution_m);
  if (!(x >= 0 && y >= 0 && x < stack.cells_x && y < stack.cells_y)) return -1;
  return static_cast<std::ptrdiff_t>(y) * stack.cells_x + static_cast<std::ptrdiff_t>(x);
}
float LabelMap::ground_m(std::ptrdiff_t cell) const { return (*stack.find("ground"))[cell]; }
int LabelMap::label(std::ptrdiff_t cell) const
{
  const float label = (*stack.find("label"))[cell];
  return std::isnan(label) ? kNotKnown : static_cast<int>(std::lround(label));
}

GroundTruth LabelMap::truth_of(double x_m, double y_m, float z_m) const
{
  const std::ptrdiff_t at = cell_at(x_m, y_m);
  if (at < 0 || label(at) == kNotKnown) return GroundTruth::NotScored;
  if (std::abs(z_m - ground_m(at)) <= kOnGround_m) return GroundTruth::Ground;  // not NaN
  return label(at) == kVegetation ? GroundTruth::NotScored : GroundTruth::Other;
}

double RealLogScore::f1() const
{
  const double p = precision.value(), r = recall.value();
  return 2 * p * r / (p + r);
}

std::vector<RealLogScore> score_real_log(
    const Sequence& sequence, const Evaluation& evaluation, const LabelMap* labels,
    const Parameters& parameters)
{
  std::vector<RealLogScore> scores(evaluation.last.size());
  for (std::size_t i = 0; i < scores.size(); ++i)
  {
    scores[i].method = evaluation.maps[i].method;
    score_window(evaluation.last[i], scores[i]);
  }
  if (!labels) return scores;
  const CellHits hits(sequence, parameters);
  for (std::size_t i = 0; i < scores.size(); ++i)
  {
    score_labels(*labels, hits, evaluation.last[i], parameters.step_threshold_m, scores[i]);
    if (scores[i].method == "talus")
      scores[i].swept_blocked = swept_blocked(sequence, *labels, parameters);
  }
  for (const ScanFrame& frame : sequence.frames)
  {
    const auto points = accepted_points(frame.view(), parameters);
    for (std::size_t i = 0; i < scores.size(); ++i)
      score_points(points, *labels, evaluation.last[i], scores[i]);
  }
  return scores;
}

}  // namespace talus::baselines
