#include "registration.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace talus::align
{
namespace
{
constexpr double kSigma_m = 0.05, kSigmaZ_m = 0.02;
constexpr double kReach_m = 1.5;  //!< where something must stand to be found
constexpr std::size_t kMinGround = 50;  //!< samples that two maps must share
constexpr double kMinInformation = 12, kMinShare = 0.01;  //!< samples, of the best direction
constexpr double kAway_m = 0.3;  //!< by which a map that lies well can be moved to lie worse
constexpr int kMaxTries = 3;
/** A map is not moved aside where it lies better by less, of what it scores: where two drives share
 * little but its edges and what has moved, some place always looks a little better. */
constexpr double kMinGain = 0.01;

constexpr double kHalfTurn = 3.14159265358979323846;
constexpr double kMinStanding = 0.85;  //!< share that fits where a map lies right
constexpr double kMinTurnGain = 0.1;  //!< of that share, by a turn
constexpr double kMinSeen = 0.4;  //!< share of what stands that the others have seen elsewhere
constexpr double kSureSeen = 0.6;  //!< of a fit that no other place is looked for
/** A map is moved by whole pixels, without a turn, where it lies as well so but for this share of
 * its score. */
constexpr double kSnapLoss = 0.01;

/** The information of the samples on (x, y, turn) where the height is free, in samples. */
Eigen::Matrix3d information(const Task& task, const Pose& pose)
{
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const StandingSample& s : task.samples.standing)
  {
    if (!(task.reference.distance_m(pose.place(s.at_m)).value < kReach_m)) continue;
    const Eigen::Matrix<double, 2, 3> j = pose.change(s.at_m);
    const Eigen::RowVector3d across = pose.turned(s.normal).transpose() * j;
    sum += s.is_line ? Eigen::Matrix3d(across.transpose() * across)
                     : Eigen::Matrix3d(j.transpose() * j);
  }
  Eigen::Vector3d with_height = Eigen::Vector3d::Zero();
  double count = 0;
  for (const GroundSample& s : task.samples.ground)
  {
    const FieldValue f = task.reference.ground(pose.place(s.at_m));
    if (std::isnan(f.value)) continue;
    const Eigen::Vector3d g =
        (f.slope.transpose() * pose.change(s.at_m)).transpose() * (kSigma_m / kSigmaZ_m);
    sum += g * g.transpose();
    with_height += g * (kSigma_m / kSigmaZ_m);
    count += (kSigma_m / kSigmaZ_m) * (kSigma_m / kSigmaZ_m);
  }
  if (count > 0) sum -= with_height * with_height.transpose() / count;
  return sum;
}

bool is_observable(double samples, double most)
{
  return samples >= kMinInformation && samples >= kMinShare * most;
}

/** The directions that the samples determine, and the others: the turn, and two on the ground. */
void divide(const Eigen::Matrix3d& information, Directions& observable, Directions& unobservable)
{
  using Axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>;
  // A turn counts as far as no shift looks the same, and the other way round.
  const Axes shifts(information.topLeftCorner<2, 2>());
  const double most = shifts.eigenvalues()[1];
  double turn = information(2, 2);
  for (int i = 0; i < 2; ++i)
    if (const double held = shifts.eigenvalues()[i]; is_observable(held, most))
      turn -=
          std::pow(shifts.eigenvectors().col(i).dot(information.topRightCorner<2, 1>()), 2) / held;
  const bool turn_observable = is_observable(turn, 0);
  (turn_observable ? observable : unobservable).emplace_back(0, 0, 1);
  Eigen::Matrix2d places = information.topLeftCorner<2, 2>();
  if (turn_observable)
    places -= information.topRightCorner<2, 1>() * information.bottomLeftCorner<1, 2>() /
              information(2, 2);
  const Axes axes(places);
  for (int i = 0; i < 2; ++i)
  {
    const Eigen::Vector2d d = axes.eigenvectors().col(i);
    (is_observable(axes.eigenvalues()[i], most) ? observable : unobservable)
        .emplace_back(d.x(), d.y(), 0);
  }
}

/** Whether a map that is moved along a direction lies worse. */
bool is_held(const Task& task, const Pose& pose, const Eigen::Vector3d& direction)
{
  const double sigma_m = std::max(kSigma_m, task.pixel_m);
  const double here = score(task, pose, sigma_m, kSigmaZ_m);
  for (const double by_m : {-kAway_m, kAway_m})
  {
    Pose moved = pose;
    moved.v.head<3>() += std::max(1.0, 4 * task.pixel_m / kAway_m) * by_m * direction;
    moved.v[3] = height_at(task, moved).median_m;
    if (here - score(task, moved, sigma_m, kSigmaZ_m) < kMinInformation) return false;
  }
  return true;
}
/** Where the map was, at the height of the others, unless it lies clearly better elsewhere. */
Pose clearly_better(const Task& task, Pose start, const Pose& found)
{
  start.v[3] = height_at(task, start).median_m;
  const double sigma_m = std::max(kSigma_m, task.pixel_m);
  const double least = (1 + kMinGain) * score(task, start, sigma_m, kSigmaZ_m);
  return score(task, found, sigma_m, kSigmaZ_m) < least ? start : found;
}
}  // namespace

Pose first_pose(const Task& task, double turn_rad, const Eigen::Vector2d& by_m)
{
  Pose pose;
  pose.turn_rad = turn_rad;
  pose.v.head<2>() = by_m;
  std::vector<Eigen::Vector2d> places;
  for (const StandingSample& s : task.samples.standing)
    if (task.reference.distance_m(pose.place(s.at_m)).value < kReach_m)
      places.push_back(pose.turned(s.at_m));
  if (static_cast<double>(places.size()) < kMinInformation)
  {
    places.clear();
    for (const GroundSample& s : task.samples.ground) places.push_back(pose.turned(s.at_m));
  }
  const double count = std::max<double>(1, static_cast<double>(places.size()));
  Eigen::Vector2d middle(0, 0);
  for (const Eigen::Vector2d& at_m : places) middle += at_m / count;
  pose.middle = middle;
  double square_m2 = 0;
  for (const Eigen::Vector2d& at_m : places)
    square_m2 += (at_m - pose.middle).squaredNorm() / count;
  pose.lever_m = std::sqrt(std::max(1.0, square_m2));
  return pose;
}

double score(const Task& task, const Pose& pose, double sigma_m, double sigma_z_m)
{
  const auto near = [](double deviations) { return std::exp(-0.5 * deviations * deviations); };
  double sum = 0, known = 0;
  for (const GroundSample& s : task.samples.ground)
    if (const FieldValue f = task.reference.ground(pose.place(s.at_m)); !std::isnan(f.value))
    {
      sum += near((s.height_m + pose.v[3] - f.value) / sigma_z_m);
      ++known;
    }
  if (known > 0) sum *= static_cast<double>(task.samples.ground.size()) / known;
  for (const StandingSample& s : task.samples.standing)
    if (const FieldValue d = task.reference.distance_m(pose.place(s.at_m)); !std::isnan(d.value))
      sum += near((d.value - s.distance_m) / sigma_m);
  return sum;
}

Height height_at(const Task& task, const Pose& pose)
{
  std::vector<double> raises_m;
  raises_m.reserve(task.samples.ground.size());
  for (const GroundSample& s : task.samples.ground)
    if (const double z = task.reference.ground_as_measured(pose.place(s.at_m)); !std::isnan(z))
      raises_m.push_back(z - s.height_m);
  if (raises_m.empty()) return {};
  const auto middle = raises_m.begin() + static_cast<std::ptrdiff_t>(raises_m.size() / 2);
  std::nth_element(raises_m.begin(), middle, raises_m.end());
  return {*middle, raises_m.size()};
}

namespace
{
/** How what stands meets what stands in the others. */
struct Standing
{
  double seen;  //!< share around which the others have seen the ground
  double same;  //!< of that: how much stands there in them, too; 1 where it is too little to tell
};
Standing standing_at(const Task& task, const Pose& pose)
{
  constexpr double kAround_m = 0.3, kSame = 1.5;  // pixels
  double count = 0, same = 0;
  for (const StandingSample& s : task.samples.standing)
  {
    const Eigen::Vector2d at_m = pose.place(s.at_m);
    int seen = 0;
    for (const double x : {-kAround_m, kAround_m})
      for (const double y : {-kAround_m, kAround_m})
        seen += !std::isnan(task.reference.ground_as_measured(at_m + Eigen::Vector2d(x, y)));
    if (seen < 2) continue;
    const double off_m = task.reference.distance_m(at_m).value - s.distance_m;
    ++count;
    same += std::abs(off_m) < kSame * task.pixel_m;
  }
  const auto all = static_cast<double>(task.samples.standing.size());
  return {count / std::max(1.0, all), count < kMinInformation ? 1 : same / count};
}

/** The whole pixels around, without a turn, that fit best; `found` where that is clearly better. */
Pose snapped(const Task& task, const Pose& found, const Directions& unobservable)
{
  const double sigma_m = task.pixel_m / 2;
  Pose best = found;
  double most = (1 - kSnapLoss) * score(task, found, sigma_m, kSigmaZ_m);
  for (int i = 0; i < 9; ++i)
  {
    const Eigen::Vector2d by_m = task.pixel_m * Eigen::Vector2d(i % 3 - 1, i / 3 - 1);
    if (std::any_of(
            unobservable.begin(), unobservable.end(),
            [&](const auto& d) { return std::abs(by_m.dot(d.template head<2>())) > 1e-9; }))
      continue;
    Pose pose = found;
    pose.v[2] = 0;
    const Eigen::Vector2d shift_m = pose.place({0, 0});
    const Eigen::Vector2d whole_m = (shift_m / task.pixel_m).array().round() * task.pixel_m;
    pose.v.head<2>() += whole_m + by_m - shift_m;
    pose.v[3] = height_at(task, pose).median_m;
    if (const double s = score(task, pose, sigma_m, kSigmaZ_m); s > most)
    {
      most = s;
      best = pose;
    }
  }
  return best;
}

/** Nearer than a cell: distances from whole cells draw to whole cells, blurred edges do not. */
Pose by_edges(const Task& task, Pose pose, const Directions& unobservable)
{
  constexpr int kSteps = 5;
  constexpr double kChanged = 0.3;  // of what stands: has come or gone
  pose.v[2] = 0;
  for (int step = 0; step < kSteps; ++step)
  {
    Eigen::Matrix2d squares = Eigen::Matrix2d::Identity() * 1e-9;
    Eigen::Vector2d sum(0, 0);
    for (const EdgeSample& s : task.samples.edges)
    {
      const FieldValue f = task.reference.edge(pose.place(s.at_m));
      const double off = s.blurred - f.value;
      if (!(std::abs(off) < kChanged)) continue;
      squares += f.slope * f.slope.transpose();
      sum += off * f.slope;
    }
    Eigen::Vector2d by_m = squares.ldlt().solve(sum);
    for (const Eigen::Vector3d& d : unobservable) by_m -= by_m.dot(d.head<2>()) * d.head<2>();
    if (!(by_m.norm() < task.pixel_m)) break;
    pose.v.head<2>() += by_m;
  }
  return pose;
}

Registration registered_from(const Task& task, const Pose& start)
{
  Registration r{start, start, {}, height_at(task, start).count >= kMinGround};
  if (!r.overlaps) return r;
  Directions observable;
  divide(information(task, start), observable, r.unobservable);
  for (int i = 0; i < kMaxTries; ++i)
  {
    r.pose = refined(task, best_nearby(task, start, observable), r.unobservable);
    r.pose.v[3] = height_at(task, r.pose).median_m;
    const auto loose = std::stable_partition(
        observable.begin(), observable.end(),
        [&](const auto& d) { return is_held(task, r.pose, d); });
    if (loose == observable.end()) break;
    r.unobservable.insert(r.unobservable.end(), loose, observable.end());
    observable.erase(loose, observable.end());
  }
  r.pose = snapped(task, clearly_better(task, start, r.pose), r.unobservable);
  r.fine = by_edges(task, r.pose, r.unobservable);
  return r;
}
}  // namespace

/** Drives that began the other way round lie half a turn apart, or a quarter; those that began
 * elsewhere lie anywhere. Maps that share no ground as they lie may have none in common. Of two
 * places that fit as well, as in a room that looks the same from both ends, neither is told. */
Registration registered(const Task& task)
{
  const Pose as_it_lies = first_pose(task, 0);
  Registration best = registered_from(task, as_it_lies);
  const bool shares_ground = best.overlaps;
  bool is_moved = false, is_one_of_several = false;
  Standing fit = shares_ground ? standing_at(task, best.pose) : Standing{0, 0};
  const auto try_from = [&](const Pose& start, const auto& is_better)
  {
    const Registration r = registered_from(task, start);
    if (!r.overlaps || !r.unobservable.empty()) return;
    const Standing its = standing_at(task, r.pose);
    if (its.same < kMinStanding) return;
    if (!is_better(its))
    {
      is_one_of_several |= is_moved && r.pose.turn_rad != best.pose.turn_rad &&
                           its.seen * its.same > fit.seen * fit.same - kMinTurnGain;
      return;
    }
    best = r;
    fit = its;
    is_moved = true;
    is_one_of_several = false;
  };
  const auto told = [&]
  {
    if (!is_one_of_several) return best;
    Registration none{as_it_lies, as_it_lies, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    none.pose.v[3] = none.fine.v[3] = height_at(task, as_it_lies).median_m;
    return none;
  };
  if (fit.same <= kMinStanding)
    for (const double turn_rad : {kHalfTurn, kHalfTurn / 2, -kHalfTurn / 2})
      try_from(
          first_pose(task, turn_rad),
          [&](const Standing& its) { return its.same >= fit.same + kMinTurnGain; });
  if (!shares_ground || (fit.same > kMinStanding && fit.seen > kSureSeen)) return told();
  for (const Pose& start : best_anywhere(task))
    try_from(
        start,
        [&](const Standing& its) {
          return its.seen > kMinSeen && its.seen * its.same > fit.seen * fit.same + kMinSeen / 2;
        });
  return told();
}

}  // namespace talus::align
