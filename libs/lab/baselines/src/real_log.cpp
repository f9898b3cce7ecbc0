#include <talus/baselines/real_log.h>

#include "cell_hits.h"

#include <cmath>

#include "nan.h"

namespace talus::baselines
{
namespace
{
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
    const bool is_said = std::abs(p.z_m - map.ground_m[static_cast<std::size_t>(k)]) <= kOnGround_m;
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
  return kNan;
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
float LabelMap::ground_m(std::ptrdiff_t cell) const
{
  return (*stack.find("ground"))[static_cast<std::size_t>(cell)];
}
int LabelMap::label(std::ptrdiff_t cell) const
{
  const float label = (*stack.find("label"))[static_cast<std::size_t>(cell)];
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
