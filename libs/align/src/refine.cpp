#include "registration.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus::align
{
namespace
{
constexpr double kSigmaZ_m = 0.02;
constexpr double kCauchy = 2;  //!< deviations beyond which ground has changed
constexpr double kInside_m = 0.3;  //!< from the edge of what is known
constexpr double kFixed = 1e4;  //!< deviations a metre
constexpr int kMaxSteps = 40;

using Cost = ceres::SizedCostFunction<1, 4>;

Pose pose_of(const Pose& start, const double* v)
{
  Pose pose = start;
  pose.v = Eigen::Map<const Eigen::Vector4d>(v);
  return pose;
}

void put(double* jacobian, const Eigen::RowVector3d& by_place, double by_z)
{
  for (int i = 0; i < 3; ++i) jacobian[i] = by_place[i];
  jacobian[3] = by_z;
}

/** Height above the ground of the others, in deviations. */
class GroundCost : public Cost
{
 public:
  GroundCost(const Task& task, const Pose& start, const GroundSample& sample)
      : task_(task), start_(start), sample_(sample)
  {
  }
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override
  {
    const Pose pose = pose_of(start_, blocks[0]);
    const FieldValue f = task_.reference.ground(pose.place(sample_.at_m));
    const bool known = !std::isnan(f.value);
    residual[0] = known ? (sample_.height_m + pose.v[3] - f.value) / kSigmaZ_m : 0;
    if (!jacobians || !jacobians[0]) return true;
    const Eigen::RowVector3d by_place =
        -f.slope.transpose() * pose.change(sample_.at_m) / kSigmaZ_m;
    put(jacobians[0], known ? by_place : Eigen::RowVector3d::Zero(), known ? 1 / kSigmaZ_m : 0);
    return true;
  }

 private:
  const Task& task_;
  const Pose& start_;
  const GroundSample& sample_;
};

/** Rises from 0, where the same stands in the others, to 1 far from all. */
class StandingCost : public Cost
{
 public:
  StandingCost(const Task& task, const Pose& start, const StandingSample& sample, double sigma_m)
      : task_(task), start_(start), sample_(sample), sigma_m_(sigma_m)
  {
  }
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override
  {
    const Pose pose = pose_of(start_, blocks[0]);
    const FieldValue d = task_.reference.distance_m(pose.place(sample_.at_m));
    const bool known = !std::isnan(d.value);
    const double off_m = d.value - sample_.distance_m;
    const double near = known ? std::exp(-0.5 * off_m * off_m / (sigma_m_ * sigma_m_)) : 0;
    residual[0] = 1 - near;
    if (!jacobians || !jacobians[0]) return true;
    Eigen::RowVector3d by_place = Eigen::RowVector3d::Zero();
    if (known)
      by_place =
          near * off_m / (sigma_m_ * sigma_m_) * d.slope.transpose() * pose.change(sample_.at_m);
    put(jacobians[0], by_place, 0);
    return true;
  }

 private:
  const Task& task_;
  const Pose& start_;
  const StandingSample& sample_;
  double sigma_m_;
};

/** No move along a direction. */
class FixedCost : public Cost
{
 public:
  FixedCost(const Pose& start, const Eigen::Vector3d& direction)
      : start_(start), direction_(direction)
  {
  }
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override
  {
    const Eigen::Map<const Eigen::Vector3d> v(blocks[0]);
    residual[0] = kFixed * direction_.dot(v - start_.v.head<3>());
    if (jacobians && jacobians[0]) put(jacobians[0], kFixed * direction_.transpose(), 0);
    return true;
  }

 private:
  const Pose& start_;
  Eigen::Vector3d direction_;
};

/** Whether ground is known all around: what comes and goes at the edge of the others must neither
 * draw the map there nor push it away. */
bool lies_inside(const Task& task, const Pose& pose, const GroundSample& sample)
{
  const Eigen::Vector2d at_m = pose.place(sample.at_m);
  for (const double x_m : {-kInside_m, kInside_m})
    for (const double y_m : {-kInside_m, kInside_m})
      if (std::isnan(task.reference.ground(at_m + Eigen::Vector2d(x_m, y_m)).value)) return false;
  return true;
}

Pose solved(const Task& task, const Pose& start, const Directions& fixed, double sigma_m)
{
  Eigen::Vector4d v = start.v;
  ceres::Problem problem;
  problem.AddParameterBlock(v.data(), 4);
  for (const GroundSample& s : task.samples.ground)
    if (lies_inside(task, start, s))
      problem.AddResidualBlock(
          new GroundCost(task, start, s), new ceres::CauchyLoss(kCauchy), v.data());
  for (const StandingSample& s : task.samples.standing)
    problem.AddResidualBlock(new StandingCost(task, start, s, sigma_m), nullptr, v.data());
  for (const Eigen::Vector3d& direction : fixed)
    problem.AddResidualBlock(new FixedCost(start, direction), nullptr, v.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = kMaxSteps;
  options.function_tolerance = 1e-10;  // much of the cost is of ground that no move changes
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw std::runtime_error("the maps could not be aligned: " + summary.message);
  return pose_of(start, v.data());
}
}  // namespace

Pose refined(const Task& task, const Pose& start, const Directions& fixed)
{
  const Pose near = solved(task, start, fixed, std::max(0.15, 2 * task.pixel_m));
  Pose pose = start;
  pose.v = near.v;
  return solved(task, pose, fixed, std::max(0.05, task.pixel_m));
}

}  // namespace talus::align
