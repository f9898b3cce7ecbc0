#include <talus/calibrate/noise_fit.h>

#include <ceres/autodiff_first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <ceres/jet.h>

#include <algorithm>
#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr int kUnknowns = kNoiseParameters + 1;  // and the share of outliers
constexpr double kRestart = 1e-3;  // an unknown below it [its unit of scale] is at zero
constexpr double kLeastVariance_m2 = 4e-8;
constexpr double kMostLeverage = 0.5;  // points that hold their plane tell nothing

/** One point: its distance from the plane, and what the variance depends on. */
struct Observation
{
  double square_m2, range_m, cosine, half_turn, reach_m;
  std::uint32_t patch;
  int block;
};

/** Sizes of the unknowns: each is scale * root^2, so that none becomes negative. */
constexpr std::array<double, kNoiseParameters> kScale{0.01, 0.001, 1.0, 0.005};

template <typename T>
struct Unknowns
{
  T c, a, lambda, ground, outliers;
};
template <typename T>
Unknowns<T> unknowns_of(const T* u)
{
  using std::exp;
  const auto positive = [&](int i) { return u[i] * u[i] * kScale[static_cast<std::size_t>(i)]; };
  return {positive(kCBeam), positive(kABeam), positive(kLambdaT), positive(kGround),
          1.0 / (1.0 + exp(-u[kNoiseParameters]))};
}

template <typename T>
T log_density(const Observation& o, const Unknowns<T>& n, bool along_beam)
{
  using std::exp;
  using std::log;
  using std::sqrt;
  const T sensor = (n.c + n.a * o.range_m) * (along_beam ? o.cosine : 1.0);
  const T turn = n.lambda * (o.range_m * o.half_turn);
  const T variance = sensor * sensor + turn * turn + n.ground * n.ground + kLeastVariance_m2;
  const T normal = exp(-0.5 * o.square_m2 / variance) / sqrt(6.283185307179586 * variance);
  return log((1.0 - n.outliers) * normal + n.outliers / (2.0 * o.reach_m));
}

/** Minus the mean log likelihood; unknowns that are not asked for stay where they are. */
struct Cost
{
  const std::vector<Observation>& observations;
  bool along_beam;
  std::array<bool, kNoiseParameters> free;
  std::array<double, kNoiseParameters> kept;

  template <typename T>
  bool operator()(const T* u, T* cost) const
  {
    Unknowns<T> n = unknowns_of(u);
    if (!free[kLambdaT]) n.lambda = T(kept[kLambdaT]);
    if (!free[kGround]) n.ground = T(kept[kGround]);
    T sum(0.0);
    for (const auto& o : observations) sum += log_density(o, n, along_beam);
    *cost = -sum / static_cast<double>(observations.size());
    return true;
  }
};

/** Planes as weighted least squares of the points, so that leverage is known exactly. */
std::vector<Observation> observations_of(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Association& a)
{
  Geometry g;
  evaluate_geometry(scans, track, v, g);
  const auto turns = half_turns(scans, track, v);
  const double block_s = std::max(1.0, (track.last_s() - track.first_s()) / 40);
  std::vector<Observation> out;
  for (std::uint32_t k = 0; k < a.patches.size(); ++k)
  {
    const Patch& p = a.patches[k];
    Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
    std::vector<Residual> rows;
    std::vector<double> weights;
    for (std::uint32_t i = p.first; i < p.first + p.count; ++i)
    {
      const Sample& s = a.samples[i];
      rows.push_back(point_to_plane(g, s.view, scans.point(s.point), p.center_m, p.plane));
      const double e = rows.back().distance_m / s.sigma_m;
      weights.push_back(1 / ((1 + e * e / (kLoss * kLoss)) * s.sigma_m * s.sigma_m));
      C += weights.back() * rows.back().by_plane * rows.back().by_plane.transpose();
    }
    const Eigen::Matrix3d C_inverse = C.inverse();
    for (std::uint32_t i = 0; i < p.count; ++i)
    {
      const Sample& s = a.samples[p.first + i];
      const View& view = scans.views()[s.view];
      const double leverage =
          weights[i] * rows[i].by_plane.dot(C_inverse * rows[i].by_plane);
      if (!(leverage < kMostLeverage)) continue;
      out.push_back(
          {rows[i].distance_m * rows[i].distance_m / (1 - leverage), s.range_m, s.cosine,
           turns[static_cast<std::size_t>(view.frame)], 8.0 * s.sigma_m, k,
           static_cast<int>((view.time_s - track.first_s()) / block_s)});
    }
  }
  return out;
}

using Jet = ceres::Jet<double, kNoiseParameters>;

/** Score of one observation by c, a, lambda and ground themselves, and its density's Jet. */
Jet density_jet(const Observation& o, const NoiseModel& m, double outliers)
{
  const Unknowns<Jet> n{Jet(m.c_beam_m, kCBeam), Jet(m.a_beam, kABeam), Jet(m.lambda_t, kLambdaT),
                        Jet(m.ground_m, kGround), Jet(outliers)};
  return log_density(o, n, m.along_beam);
}

/** Deviations from the scores: their own products (information) between those, summed by patch and
 * by time, that share errors. */
void add_sigmas(const std::vector<Observation>& observations, NoiseFit& fit)
{
  using V = Eigen::Matrix<double, kNoiseParameters, 1>;
  using M = Eigen::Matrix<double, kNoiseParameters, kNoiseParameters>;
  M information = M::Zero(), by_patch = M::Zero(), by_block = M::Zero();
  std::vector<V> blocks(64, V::Zero());
  V patch = V::Zero();
  for (std::size_t i = 0; i < observations.size(); ++i)
  {
    const auto& o = observations[i];
    const V score = density_jet(o, fit.model, fit.outlier_share).v;
    information += score * score.transpose();
    patch += score;
    blocks[static_cast<std::size_t>(std::clamp(o.block, 0, 63))] += score;
    if (i + 1 < observations.size() && observations[i + 1].patch == o.patch) continue;
    by_patch += patch * patch.transpose();
    patch.setZero();
  }
  for (const V& b : blocks) by_block += b * b.transpose();
  std::vector<int> index;
  for (int i = 0; i < kNoiseParameters; ++i)
    if (fit.constrained[static_cast<std::size_t>(i)]) index.push_back(i);
  const Eigen::MatrixXd I = information(index, index);
  const Eigen::MatrixXd inverse = I.inverse();
  const Eigen::MatrixXd extra = (by_patch + by_block - information)(index, index);
  for (std::size_t k = 0; k < index.size(); ++k)
  {
    const auto i = static_cast<Eigen::Index>(k);
    const double alone = inverse(i, i), clustered = (inverse * extra * inverse)(i, i);
    fit.sigma[static_cast<std::size_t>(index[k])] = std::sqrt(std::max(alone, clustered));
  }
}

NoiseFit fit_kind(const std::vector<Observation>& observations, bool along_beam)
{
  double turned = 0;
  for (const auto& o : observations) turned = std::max(turned, o.half_turn);
  Cost cost{observations, along_beam, {true, true, turned > 1e-5, along_beam}, {}};
  std::array<double, kUnknowns> u{1, 1, cost.free[kLambdaT] ? 0.5 : 0, cost.free[kGround] ? 0.7 : 0, -4};
  ceres::GradientProblem problem(
      new ceres::AutoDiffFirstOrderFunction<Cost, kUnknowns>(new Cost(cost)));
  ceres::GradientProblemSolver::Options options;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-10;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, u.data(), &summary);

  const auto n = unknowns_of(u.data());
  NoiseFit fit;
  fit.model = {along_beam, n.c, n.a, cost.free[kLambdaT] ? n.lambda : 0, cost.free[kGround] ? n.ground : 0};
  fit.outlier_share = n.outliers;
  fit.points = observations.size();
  fit.log_likelihood = -summary.final_cost;
  const std::array<double*, kNoiseParameters> values{
      &fit.model.c_beam_m, &fit.model.a_beam, &fit.model.lambda_t, &fit.model.ground_m};
  for (std::size_t i = 0; i < kNoiseParameters; ++i)
  {
    fit.constrained[i] = cost.free[i] && *values[i] > kRestart * kScale[i];
    if (!fit.constrained[i]) *values[i] = 0;
  }
  add_sigmas(observations, fit);
  return fit;
}
}  // namespace

NoiseFit fit_noise(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Association& a,
    NoiseKind kind)
{
  const auto observations = observations_of(scans, track, v, a);
  if (kind == NoiseKind::Beam) return fit_kind(observations, true);
  if (kind == NoiseKind::Height) return fit_kind(observations, false);
  const NoiseFit beam = fit_kind(observations, true), height = fit_kind(observations, false);
  // One unknown more must be worth it (Bayesian information criterion).
  const auto n = static_cast<double>(observations.size());
  const double price = std::log(n) / (2 * n);
  return beam.log_likelihood - price > height.log_likelihood ? beam : height;
}

}  // namespace talus::calibrate
