#include <talus/calibrate/noise_fit.h>

#include <ceres/jet.h>
#include <talus/io/quantile.h>

#include <algorithm>
#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr int kMaxSteps = 60;
constexpr double kMinOdds = -9;  // of an outlier, as a logarithm
constexpr double kSettledGain = 1e-9;  // gain of the mean log likelihood
constexpr double kSignificantVariance =
    2;  // deviations from 0 that a variance must have to be kept
constexpr double kMinVariance_m2 = 1e-12;
constexpr double kMaxLeverage = 0.5;  // points that hold their surface have no information
constexpr std::uint32_t kFewPointsOfPatch = 24;  // on a patch whose surface has six unknowns
constexpr std::size_t kMaxPoints = 50000;
constexpr double kOutlying = 4;  // deviations; no share in the surface, so that leverage is exact
constexpr double kUneven = 4;  // deviations by which a patch may scatter more than usual
constexpr int kBlocks = 40;  // of time
constexpr double kModelError = 0.02;  // of c_beam and a_beam: surfaces are never quite quadratic
constexpr double kMinTurn = 1e-5;  // sin(theta/2) of a robot that tilts

/** One point: its distance from the plane, and what the variance depends on. */
struct Observation
{
  double square_m2, range_m, cosine, half_turn, reach_m;
  std::uint32_t patch;
  int block;
};

/** The unknowns: c_beam [m], a_beam, and squares of lambda_t and of the ground's roughness [m^2],
 * none negative, whose derivatives are regular at 0; then the log odds of an outlier. */
enum Unknown : int
{
  kC,
  kA,
  kLambda2,
  kGround2,
  kOdds,
  kUnknowns
};
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Products = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Jet = ceres::Jet<double, kUnknowns>;
using Free = std::array<bool, kUnknowns>;

/** Log likelihood of one point: normal, or anywhere within its reach. */
Jet log_density(const Observation& o, const Unknowns& u, bool along_beam)
{
  const auto unknown = [&](int i) { return Jet(u[i], i); };
  const Jet sensor = (unknown(kC) + unknown(kA) * o.range_m) * (along_beam ? o.cosine : 1.0);
  const double turn = o.range_m * o.half_turn;
  const Jet variance =
      sensor * sensor + unknown(kLambda2) * (turn * turn) + unknown(kGround2) + kMinVariance_m2;
  const Jet normal = exp(-0.5 * o.square_m2 / variance) / sqrt(6.283185307179586 * variance);
  const Jet outliers = 1.0 / (1.0 + exp(-unknown(kOdds)));
  return log((1.0 - outliers) * normal + outliers / (2.0 * o.reach_m));
}

/** Sums over all points: log likelihood, its gradient, and the products of the points' gradients.
 */
struct Likelihood
{
  double value = 0;
  Unknowns gradient = Unknowns::Zero();
  Products information = Products::Zero();
};
Likelihood likelihood_of(
    const std::vector<Observation>& observations, const Unknowns& u, bool along_beam)
{
  Likelihood sum;
  for (const auto& o : observations)
  {
    const Jet d = log_density(o, u, along_beam);
    sum.value += d.a;
    sum.gradient += d.v;
    sum.information += d.v * d.v.transpose();
  }
  return sum;
}

std::vector<int> indices_of(const Free& free)
{
  std::vector<int> index;
  for (int i = 0; i < kUnknowns; ++i)
    if (free[static_cast<std::size_t>(i)]) index.push_back(i);
  return index;
}

/** A damped step of scoring; unknowns that would become negative stop at 0. */
Unknowns stepped(const Unknowns& u, const Likelihood& l, Free free, double damping)
{
  for (int i = kC; i < kOdds; ++i)  // those at 0 that want to go below stay there
    if (u[i] <= 0 && l.gradient[i] <= 0) free[static_cast<std::size_t>(i)] = false;
  const auto index = indices_of(free);
  Eigen::MatrixXd I = l.information(index, index);
  I.diagonal() *= 1 + damping;
  Unknowns next = u;
  next(index) += I.ldlt().solve(Eigen::VectorXd(l.gradient(index)));
  next.head<kOdds>() = next.head<kOdds>().cwiseMax(0);
  next[kOdds] = std::max(next[kOdds], kMinOdds);
  return next;
}

/** The most likely unknowns, from `u` on. */
Unknowns maximise(
    const std::vector<Observation>& observations, Unknowns u, const Free& free, bool along_beam)
{
  Likelihood now = likelihood_of(observations, u, along_beam);
  double damping = 0.1;
  for (int step = 0; step < kMaxSteps && damping < 1e6; ++step)
  {
    const Unknowns next = stepped(u, now, free, damping);
    const Likelihood then = likelihood_of(observations, next, along_beam);
    if (!(then.value > now.value))
    {
      damping *= 8;
      continue;
    }
    const double gain = (then.value - now.value) / static_cast<double>(observations.size());
    u = next;
    now = then;
    damping /= 5;
    if (gain < kSettledGain) break;
  }
  return u;
}

/** The distances of a patch's points from a curved surface, z quadratic in x and y: what curvature
 * does not fit a plane is no noise. */
class CurvedPatch
{
 public:
  CurvedPatch(const ScanSet& scans, const Geometry& g, const Association& a, const Patch& p)
  {
    for (std::uint32_t i = p.first; i < p.first + p.count; ++i)
    {
      const Sample& s = a.samples[i];
      const Residual r = residual_of(g, a, s, p, scans.point(s.point), p.plane);
      const double u = r.by_plane[1] / r.by_plane[0] / p.size_m;
      const double v = r.by_plane[2] / r.by_plane[0] / p.size_m;
      basis_.emplace_back();
      basis_.back() << 1, u, v, u * u, u * v, v * v;
      distance_m_.push_back(r.distance_m);
      const double e = r.distance_m / s.sigma_m;
      weight_.push_back(std::abs(e) < kOutlying ? 1 / (s.sigma_m * s.sigma_m) : 0);
    }
    Terms b = Terms::Zero();
    Normal N = Normal::Zero();
    for (std::size_t i = 0; i < basis_.size(); ++i)
    {
      N += weight_[i] * basis_[i] * basis_[i].transpose();
      b += weight_[i] * distance_m_[i] * basis_[i];
    }
    inverse_ = N.inverse();
    surface_ = inverse_ * b;
  }

  bool solved() const { return surface_.allFinite(); }
  double distance_m(std::size_t i) const { return distance_m_[i] - surface_.dot(basis_[i]); }
  /** How much the surface follows this point, 0..1. */
  double leverage(std::size_t i) const { return weight_[i] * basis_[i].dot(inverse_ * basis_[i]); }
  /** Mean square of the distances by their deviations, over what is free of them. */
  double variance_factor() const
  {
    double sum = 0, points = 0;
    for (std::size_t i = 0; i < basis_.size(); ++i)
    {
      sum += weight_[i] * std::pow(distance_m(i), 2);
      points += weight_[i] > 0;
    }
    return sum / std::max(1.0, points - 6);
  }

 private:
  using Terms = Eigen::Matrix<double, 6, 1>;
  using Normal = Eigen::Matrix<double, 6, 6>;
  std::vector<Terms> basis_;
  std::vector<double> distance_m_, weight_;
  Normal inverse_;
  Terms surface_;
};

/** The patches whose points scatter as those of most patches do: the others have an edge, or
 * something grows there. */
std::vector<std::pair<std::uint32_t, CurvedPatch>> even_patches(
    const ScanSet& scans, const Geometry& g, const Association& a)
{
  const double share = static_cast<double>(kMaxPoints) / static_cast<double>(a.samples.size());
  std::vector<std::pair<std::uint32_t, CurvedPatch>> patches;
  std::vector<double> factors;
  for (std::uint32_t k = 0; k < a.patches.size(); ++k)
  {
    if (a.patches[k].count < kFewPointsOfPatch || chance(k, 3) >= share) continue;
    CurvedPatch patch(scans, g, a, a.patches[k]);
    if (!patch.solved()) continue;
    factors.push_back(patch.variance_factor());
    patches.emplace_back(k, std::move(patch));
  }
  const double usual = io::quantile(factors, 0.5);
  const auto uneven = [&](const auto& entry)
  {
    const double deviation = std::sqrt(2.0 / (a.patches[entry.first].count - 6));
    return entry.second.variance_factor() > usual * (1 + kUneven * deviation);
  };
  patches.erase(std::remove_if(patches.begin(), patches.end(), uneven), patches.end());
  return patches;
}

std::vector<Observation> observations_of(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Association& a)
{
  Geometry g;
  evaluate_geometry(scans, track, v, g);
  const auto turns = half_turns(scans, track, v);
  const double block_s = std::max(1.0, (track.last_s() - track.first_s()) / kBlocks);
  std::vector<Observation> out;
  for (const auto& [k, patch] : even_patches(scans, g, a))
  {
    const Patch& p = a.patches[k];
    for (std::uint32_t i = 0; i < p.count; ++i)
    {
      const double leverage = patch.leverage(i);
      if (!(leverage < kMaxLeverage)) continue;
      const Sample& s = a.samples[p.first + i];
      const View& view = scans.views()[s.view];
      const double distance_m = patch.distance_m(i);
      out.push_back(
          {distance_m * distance_m / (1 - leverage), s.range_m, s.cosine,
           turns[static_cast<std::size_t>(view.frame)], 8.0 * s.sigma_m, k,
           static_cast<int>((view.time_s - track.first_s()) / block_s)});
    }
  }
  return out;
}

/** Covariance of the free unknowns: from the products of the points' gradients, and from those
 * summed over patches and over stretches of time, whose points share errors; the larger counts. */
Unknowns sigmas_of(
    const std::vector<Observation>& observations, const Unknowns& u, const Free& free,
    bool along_beam)
{
  Products alone = Products::Zero(), clustered = Products::Zero();
  std::vector<Unknowns> blocks(kBlocks + 2, Unknowns::Zero());
  Unknowns patch = Unknowns::Zero();
  for (std::size_t i = 0; i < observations.size(); ++i)
  {
    const auto& o = observations[i];
    const Unknowns score = log_density(o, u, along_beam).v;
    alone += score * score.transpose();
    patch += score;
    blocks[static_cast<std::size_t>(std::clamp(o.block, 0, kBlocks + 1))] += score;
    if (i + 1 < observations.size() && observations[i + 1].patch == o.patch) continue;
    clustered += patch * patch.transpose();
    patch.setZero();
  }
  for (const Unknowns& b : blocks) clustered += b * b.transpose();
  clustered -= alone;
  const auto index = indices_of(free);
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(alone(index, index)).inverse();
  const Eigen::MatrixXd robust = inverse * clustered(index, index) * inverse;
  Unknowns sigma = Unknowns::Zero();
  sigma(index) = inverse.diagonal().cwiseMax(robust.diagonal()).cwiseSqrt();
  return sigma;
}

void leave_out_zeros(const Unknowns& u, Free& free)
{
  for (int k = kC; k < kOdds; ++k) free[static_cast<std::size_t>(k)] &= u[k] > 0;
  free[kOdds] &= u[kOdds] > kMinOdds;
}

NoiseFit fit_kind(const std::vector<Observation>& observations, bool along_beam)
{
  double turned = 0;
  for (const auto& o : observations) turned = std::max(turned, o.half_turn);
  Free free{true, true, turned > kMinTurn, along_beam, true};
  Unknowns u;
  u << 0.01, 0.001, free[kLambda2] ? 0.01 : 0, free[kGround2] ? 1e-6 : 0, -5;
  u = maximise(observations, u, free, along_beam);
  Unknowns sigma;
  // Variances that chance would explain go: else they take from c_beam and a_beam.
  for (const int i : {kGround2, kLambda2})
  {
    auto without = free;
    leave_out_zeros(u, without);
    sigma = sigmas_of(observations, u, without, along_beam);
    if (u[i] > kSignificantVariance * sigma[i] && u[i] > 0) continue;
    u[i] = 0;
    free[static_cast<std::size_t>(i)] = false;
    u = maximise(observations, u, free, along_beam);
  }
  leave_out_zeros(u, free);
  sigma = sigmas_of(observations, u, free, along_beam);

  NoiseFit fit;
  const double lambda = std::sqrt(u[kLambda2]), ground = std::sqrt(u[kGround2]);
  fit.model = {along_beam, u[kC], u[kA], lambda, ground};
  fit.constrained = {free[kC], free[kA], free[kLambda2], free[kGround2]};
  fit.sigma = {
      sigma[kC], sigma[kA], lambda > 0 ? sigma[kLambda2] / (2 * lambda) : 0,
      ground > 0 ? sigma[kGround2] / (2 * ground) : 0};
  for (const int i : {kCBeam, kABeam})
    fit.sigma[static_cast<std::size_t>(i)] =
        std::hypot(fit.sigma[static_cast<std::size_t>(i)], kModelError * u[i]);
  fit.turns = turned > kMinTurn;
  fit.outlier_share = 1 / (1 + std::exp(-u[kOdds]));
  fit.points = observations.size();
  fit.log_likelihood =
      likelihood_of(observations, u, along_beam).value / static_cast<double>(observations.size());
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
