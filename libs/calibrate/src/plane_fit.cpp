#include "plane_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr double kCauchy = 3;  // deviations at which a point's weight has halved
constexpr int kBins = 24;
constexpr double kMinCosine = 0.01;

/** Height of the level around which most points lie: what stands on the ground is spread out. */
double busiest_level_m(const Hits& hits)
{
  float low = HUGE_VALF, high = -HUGE_VALF;
  for (const Hit* h : hits)
  {
    low = std::min(low, h->at_m.z());
    high = std::max(high, h->at_m.z());
  }
  const float bin = std::max(0.02F, (high - low) / kBins);
  std::array<int, kBins + 3> count{};
  for (const Hit* h : hits)
    ++count[static_cast<std::size_t>(std::min((h->at_m.z() - low) / bin, kBins * 1.0F)) + 1];
  std::size_t best = 1;
  const auto three = [&](std::size_t i) { return count[i - 1] + count[i] + count[i + 1]; };
  for (std::size_t i = 1; i <= kBins + 1; ++i)
    if (three(i) > three(best)) best = i;
  return low + bin * (static_cast<double>(best) - 0.5);
}

/** Distances from the plane, and the deviations that the noise model gives them. */
void measure(
    const Hits& hits, const Eigen::Vector2d& center_m, const NoiseModel& noise, PlaneFit& fit)
{
  const Eigen::Vector3d normal = Eigen::Vector3d(-fit.plane[1], -fit.plane[2], 1).normalized();
  for (std::size_t i = 0; i < hits.size(); ++i)
  {
    const Hit& h = *hits[i];
    const double cosine = std::abs(normal.dot(h.beam.cast<double>()));
    const Eigen::Vector2d at = h.offset(center_m);
    fit.cosine[i] = static_cast<float>(cosine);
    fit.sigma_m[i] =
        static_cast<float>(std::sqrt(noise.variance_m2(h.range_m, cosine, h.half_turn)));
    fit.distance_m[i] =
        static_cast<float>((h.at_m.z() - fit.plane[0] - at.dot(fit.plane.tail<2>())) * normal.z());
  }
}

/** One step of reweighted least squares; `widen` multiplies the deviations. */
bool improve(
    const Hits& hits, const Eigen::Vector2d& center_m, bool along_beam, double widen, PlaneFit& fit)
{
  const Eigen::Vector3d normal = Eigen::Vector3d(-fit.plane[1], -fit.plane[2], 1).normalized();
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < hits.size(); ++i)
  {
    const double s = fit.sigma_m[i], e = fit.distance_m[i] / (kCauchy * widen * s);
    const double weight = 1 / (s * s * (1 + e * e));
    const double lift = fit.distance_m[i] / normal.z();
    Eigen::Vector2d at = hits[i]->offset(center_m);  // as in beam_to_plane()
    if (along_beam) at = beam_on_plane(*hits[i], fit.distance_m[i], fit.plane) - center_m;
    const Eigen::Vector3d q(1, at.x(), at.y());
    N += weight * q * q.transpose();
    b += weight * q * lift;
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(N);
  const auto d = solver.vectorD();
  if (!(d.minCoeff() > 1e-9 * d.maxCoeff())) return false;  // points in a line
  fit.plane += solver.solve(b);
  return fit.plane.allFinite();
}
}  // namespace

Eigen::Vector2d beam_on_plane(const Hit& hit, double distance_m, const Plane& plane)
{
  const Eigen::Vector3d beam = hit.beam.cast<double>();
  const double along = Eigen::Vector3d(-plane[1], -plane[2], 1).normalized().dot(beam);
  const Eigen::Vector2d at = hit.at_m.head<2>().cast<double>();
  if (std::abs(along) < kMinCosine) return at;
  return at - distance_m / along * beam.head<2>();
}

double robust_squares(double distance_m, double sigma_m)
{
  const double e = distance_m / sigma_m / kCauchy;
  return kCauchy * kCauchy * std::log1p(e * e);
}

PlaneFit fit_plane(const Hits& hits, const Eigen::Vector2d& center_m, const NoiseModel& noise)
{
  PlaneFit fit;
  for (auto* column : {&fit.sigma_m, &fit.cosine, &fit.distance_m}) column->resize(hits.size());
  fit.plane = Plane(busiest_level_m(hits), 0, 0);
  for (const double widen : {20.0, 8.0, 3.0, 1.5, 1.0, 1.0})
  {
    measure(hits, center_m, noise, fit);
    if (!improve(hits, center_m, noise.along_beam, widen, fit)) return fit;
  }
  measure(hits, center_m, noise, fit);
  for (std::size_t i = 0; i < hits.size(); ++i)
    fit.weighted_squares += robust_squares(fit.distance_m[i], fit.sigma_m[i]);
  fit.solved = true;
  return fit;
}

}  // namespace talus::calibrate
