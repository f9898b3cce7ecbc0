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

/** Turned around the middle of what tells the place: what stands there, else of all ground. */
Pose first_pose(const Task& task)
{
  Pose pose;
  std::vector<Eigen::Vector2d> places;
  for (const StandingSample& s : task.samples.standing)
    if (task.reference.distance_m(s.at_m).value < kReach_m) places.push_back(s.at_m);
  if (static_cast<double>(places.size()) < kMinInformation)
  {
    places.clear();
    for (const GroundSample& s : task.samples.ground) places.push_back(s.at_m);
  }
  const double count = std::max<double>(1, static_cast<double>(places.size()));
  for (const Eigen::Vector2d& at_m : places) pose.middle += at_m / count;
  double square_m2 = 0;
  for (const Eigen::Vector2d& at_m : places)
    square_m2 += (at_m - pose.middle).squaredNorm() / count;
  pose.lever_m = std::sqrt(std::max(1.0, square_m2));
  return pose;
}

/** What the samples tell of (x, y, turn) where the height is free, in samples. */
Eigen::Matrix3d information(const Task& task, const Pose& pose)
{
  Eigen::Matrix3d told = Eigen::Matrix3d::Zero();
  for (const StandingSample& s : task.samples.standing)
  {
    if (!(task.reference.distance_m(pose.place(s.at_m)).value < kReach_m)) continue;
    const Eigen::Matrix<double, 2, 3> j = pose.change(s.at_m);
    const Eigen::RowVector3d across = s.normal.transpose() * j;
    told += s.is_line ? Eigen::Matrix3d(across.transpose() * across)
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
    told += g * g.transpose();
    with_height += g * (kSigma_m / kSigmaZ_m);
    count += (kSigma_m / kSigmaZ_m) * (kSigma_m / kSigmaZ_m);
  }
  if (count > 0) told -= with_height * with_height.transpose() / count;
  return told;
}

bool is_told(double samples, double most)
{
  return samples >= kMinInformation && samples >= kMinShare * most;
}

/** The directions that the samples can tell, and the others: the turn, and two on the ground. */
void divide(const Eigen::Matrix3d& information, Directions& told, Directions& untold)
{
  using Axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>;
  // A turn counts as far as no shift looks the same, and the other way round.
  const Axes shifts(information.topLeftCorner<2, 2>());
  const double most = shifts.eigenvalues()[1];
  double turn = information(2, 2);
  for (int i = 0; i < 2; ++i)
    if (const double held = shifts.eigenvalues()[i]; is_told(held, most))
      turn -=
          std::pow(shifts.eigenvectors().col(i).dot(information.topRightCorner<2, 1>()), 2) / held;
  const bool turn_told = is_told(turn, 0);
  (turn_told ? told : untold).emplace_back(0, 0, 1);
  Eigen::Matrix2d places = information.topLeftCorner<2, 2>();
  if (turn_told)
    places -= information.topRightCorner<2, 1>() * information.bottomLeftCorner<1, 2>() /
              information(2, 2);
  const Axes axes(places);
  for (int i = 0; i < 2; ++i)
  {
    const Eigen::Vector2d d = axes.eigenvectors().col(i);
    (is_told(axes.eigenvalues()[i], most) ? told : untold).emplace_back(d.x(), d.y(), 0);
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

Registration registered(const Task& task)
{
  const Pose start = first_pose(task);
  Registration r{start, {}, height_at(task, start).count >= kMinGround};
  if (!r.overlaps) return r;
  Directions told;
  divide(information(task, start), told, r.untold);
  for (int i = 0; i < kMaxTries; ++i)
  {
    r.pose = refined(task, best_nearby(task, start, told), r.untold);
    r.pose.v[3] = height_at(task, r.pose).median_m;
    const auto loose = std::stable_partition(
        told.begin(), told.end(), [&](const auto& d) { return is_held(task, r.pose, d); });
    if (loose == told.end()) break;
    r.untold.insert(r.untold.end(), loose, told.end());
    told.erase(loose, told.end());
  }
  r.pose = clearly_better(task, start, r.pose);
  return r;
}

}  // namespace talus::align
