#include <talus/baselines/real_log.h>

#include <talus/point_labels.h>
#include <talus/sim/geometry.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace talus::baselines
{
namespace
{
constexpr std::array<double, 2> kWithin_m{12, 40};

/** Where a point of a scan is in the map, and how far from the sensor, seen from above [m]. */
struct PointInMap
{
  double x_m, y_m, z_m, away_m;
};

PointInMap point_in_map(const ScanFrame& scan, std::size_t i)
{
  const Pose& T = scan.T_map_sensor;
  const sim::Vec3 p = sim::transform(T, {scan.x_m[i], scan.y_m[i], scan.z_m[i]});
  return {p.x, p.y, p.z, std::hypot(p.x - T.x(), p.y - T.y())};
}

/** The sums of one row of scores. */
class Sum
{
 public:
  Sum(bool alone, double within_m)
  {
    score_.alone = alone;
    score_.within_m = within_m;
  }
  void add(double away_m, GroundTruth truth, PointLabel label)
  {
    if (away_m > score_.within_m) return;
    ++score_.points;
    const bool is_ground = truth == GroundTruth::Ground, said = label == PointLabel::Ground;
    right_ += is_ground && said;
    said_ += said;
    ground_ += is_ground;
  }
  void end_scan()
  {
    if (said_ > 0 && ground_ > 0)
    {
      const double p = right_ / said_, r = right_ / ground_;
      ++score_.scans;
      score_.precision += p;
      score_.recall += r;
      score_.f1 += p + r > 0 ? 2 * p * r / (p + r) : 0;
    }
    right_ = said_ = ground_ = 0;
  }
  LabelScore result() const
  {
    LabelScore mean = score_;
    for (double* figure : {&mean.precision, &mean.recall, &mean.f1}) *figure /= mean.scans;
    return mean;
  }

 private:
  LabelScore score_;
  double right_ = 0, said_ = 0, ground_ = 0;  //!< points of this scan
};

void add_scan(
    const ElevationMapper& map, const ScanFrame& scan, const std::vector<GroundTruth>& truth,
    std::vector<Sum>& sums)
{
  const std::vector<PointLabel> labels = label_points(map, scan.view());
  const Window window = map.window();
  for (std::size_t i = 0; i < labels.size(); ++i)
  {
    if (truth[i] == GroundTruth::NotScored) continue;
    const PointInMap p = point_in_map(scan, i);
    if (!window.index_at(p.x_m, p.y_m)) continue;
    for (Sum& sum : sums) sum.add(p.away_m, truth[i], labels[i]);
  }
  for (Sum& sum : sums) sum.end_scan();
}

std::vector<Sum> sums_for(const Parameters& p, bool alone)
{
  std::vector<Sum> sums;
  for (const double within_m : kWithin_m)
    if (within_m <= p.window_m / 2) sums.emplace_back(alone, within_m);
  sums.emplace_back(alone, std::numeric_limits<double>::infinity());
  return sums;
}
}  // namespace

GroundTruth ground_truth_of(std::uint32_t semantic_kitti_label)
{
  switch (semantic_kitti_label & 0xFFFFU)
  {
    case 0:  // no label
    case 1:  // an outlier
    case 70:  // vegetation
      return GroundTruth::NotScored;
    case 40:  // road
    case 44:  // parking
    case 48:  // sidewalk
    case 49:  // other ground
    case 60:  // lane marking
    case 72:  // terrain
      return GroundTruth::Ground;
    default:
      return GroundTruth::Other;
  }
}

std::vector<GroundTruth> ground_truth_of(const ScanFrame& scan, const LabelMap& labels)
{
  std::vector<GroundTruth> truth(scan.x_m.size(), GroundTruth::NotScored);
  for (std::size_t i = 0; i < truth.size(); ++i)
  {
    const PointInMap p = point_in_map(scan, i);
    if (std::isfinite(p.x_m + p.y_m))
      truth[i] = labels.truth_of(p.x_m, p.y_m, static_cast<float>(p.z_m));
  }
  return truth;
}

std::vector<LabelScore> score_labels(
    const Sequence& sequence, const std::vector<std::vector<GroundTruth>>& truth,
    const Parameters& parameters, Backend backend)
{
  std::vector<LabelScore> scores;
  for (const bool alone : {false, true})
  {
    if (alone && sequence.frames.size() == 1) continue;
    ElevationMapper map(parameters, backend);
    std::vector<Sum> sums = sums_for(parameters, alone);
    for (std::size_t f = 0; f < sequence.frames.size(); ++f)
    {
      if (alone) map.clear();
      map.update(sequence.frames[f].view());
      add_scan(map, sequence.frames[f], truth[f], sums);
    }
    for (const Sum& sum : sums) scores.push_back(sum.result());
  }
  return scores;
}

}  // namespace talus::baselines
