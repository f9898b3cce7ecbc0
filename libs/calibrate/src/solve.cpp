#include <talus/calibrate/held_out.h>

#include <ceres/ceres.h>

#include <memory>
#include <stdexcept>

namespace talus::calibrate
{
namespace
{
constexpr int kMaxIterations = 12;

/** Keeps the geometry that all residuals share up to date. */
class SharedGeometry : public ceres::EvaluationCallback
{
 public:
  SharedGeometry(const ScanSet& scans, const PoseTrack& track, const Vector& v)
      : scans_(scans), track_(track), v_(v)
  {
  }
  void PrepareForEvaluation(bool, bool is_new) override
  {
    if (is_new) evaluate_geometry(scans_, track_, v_, geometry_);
  }
  const Geometry& geometry() const { return geometry_; }

 private:
  const ScanSet& scans_;
  const PoseTrack& track_;
  const Vector& v_;
  Geometry geometry_;
};

/** Distance of a point from its plane, in deviations. */
class PointCost : public ceres::SizedCostFunction<1, kParameters, 3>
{
 public:
  PointCost(
      const Geometry& g, const Association& a, const Patch& patch, const Sample& s,
      const Eigen::Vector3d& p_sensor)
      : geometry_(g), association_(a), patch_(patch), sample_(s), p_sensor_(p_sensor)
  {
  }
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override
  {
    const Residual r =
        residual_of(geometry_, association_, sample_, patch_, p_sensor_, Plane(blocks[1]));
    residual[0] = r.distance_m / sample_.sigma_m;
    if (!jacobians) return true;
    const auto put = [&](double* to, const auto& derivative)
    {
      for (Eigen::Index i = 0; to && i < derivative.size(); ++i)
        to[i] = derivative[i] / sample_.sigma_m;
    };
    put(jacobians[0], r.by_parameters);
    put(jacobians[1], r.by_plane);
    return true;
  }

 private:
  const Geometry& geometry_;
  const Association& association_;
  const Patch& patch_;
  const Sample& sample_;
  Eigen::Vector3d p_sensor_;
};

/** One of the three things that contact says. */
class ContactCost : public ceres::SizedCostFunction<1, 3>
{
 public:
  ContactCost(const Contact& c, const ContactScatter& s, int row)
      : contact_(c), scatter_(s), row_(row)
  {
  }
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override
  {
    const auto r = contact_residual(contact_, Plane(blocks[0]), scatter_);
    residual[0] = r.value[row_];
    for (int i = 0; jacobians && jacobians[0] && i < 3; ++i) jacobians[0][i] = r.by_plane(row_, i);
    return true;
  }

 private:
  Contact contact_;
  ContactScatter scatter_;
  int row_;
};

void add_patch(
    const ScanSet& scans, const Geometry& g, const Association& a, Patch& patch, Vector& v,
    ceres::LossFunction* loss, ceres::Problem& problem)
{
  for (std::uint32_t i = patch.first; i < patch.first + patch.count; ++i)
  {
    const Sample& s = a.samples[i];
    problem.AddResidualBlock(
        new PointCost(g, a, patch, s, scans.point(s.point)), loss, v.data(), patch.plane.data());
  }
  if (patch.contact)
    for (int row = 0; row < 3; ++row)
      problem.AddResidualBlock(
          new ContactCost(*patch.contact, a.scatter, row), loss, patch.plane.data());
}

void hold_the_others(const Choice& chosen, Vector& v, ceres::Problem& problem)
{
  std::vector<int> held;
  for (int i = 0; i < kParameters; ++i)
    if (!chosen[static_cast<std::size_t>(i)]) held.push_back(i);
  if (held.size() == kParameters)
    problem.SetParameterBlockConstant(v.data());
  else if (!held.empty())
    problem.SetManifold(v.data(), new ceres::SubsetManifold(kParameters, held));
}

ceres::Solver::Options solver_options(Association& a, Vector& v)
{
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::DENSE_SCHUR;
  o.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (Patch& p : a.patches) o.linear_solver_ordering->AddElementToGroup(p.plane.data(), 0);
  o.linear_solver_ordering->AddElementToGroup(v.data(), 1);
  o.max_num_iterations = kMaxIterations;
  o.function_tolerance = 1e-7;
  o.num_threads = 1;  // several add up in any order, which changes a fit that is hardly observable
  o.logging_type = ceres::SILENT;
  return o;
}
}  // namespace

Vector solve(
    const ScanSet& scans, const PoseTrack& track, const Vector& start, const Choice& chosen,
    Association& a)
{
  Vector v = start;
  SharedGeometry shared(scans, track, v);
  ceres::CauchyLoss loss(kLoss);
  ceres::Problem::Options options;
  options.evaluation_callback = &shared;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  problem.AddParameterBlock(v.data(), kParameters);
  for (Patch& p : a.patches) add_patch(scans, shared.geometry(), a, p, v, &loss, problem);
  hold_the_others(chosen, v, problem);
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(a, v), &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw std::runtime_error("the least-squares problem cannot be solved: " + summary.message);
  return v;
}

}  // namespace talus::calibrate
