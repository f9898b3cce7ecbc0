#include <talus/calibrate/held_out.h>
#include <talus/calibrate/information.h>

#include <algorithm>
#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr std::uint32_t kMinSamples = 6;  // of a patch

/** What one half of the frames shows. */
Association half_of(const ScanSet& scans, const Association& all, bool is_second)
{
  const auto is_of_it = [&](const Sample& s)
  { return (scans.views()[s.view].frame >= scans.frames() / 2) == is_second; };
  const double middle_s = scans.stamp_s(scans.frames() / 2);
  Association half;
  half.scatter = all.scatter;
  half.along_beam = all.along_beam;
  for (Patch p : all.patches)
  {
    const auto begin = all.samples.begin() + p.first;
    p.first = static_cast<std::uint32_t>(half.samples.size());
    std::copy_if(begin, begin + p.count, std::back_inserter(half.samples), is_of_it);
    p.count = static_cast<std::uint32_t>(half.samples.size()) - p.first;
    if (p.contact && (p.contact->time_s >= middle_s) != is_second) p.contact.reset();
    if (p.count >= kMinSamples)
      half.patches.push_back(p);
    else
      half.samples.resize(p.first);
  }
  return half;
}
}  // namespace

Vector disagreement_of_halves(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Choice& chosen,
    const Association& a)
{
  Vector difference = Vector::Zero(), variance = Vector::Zero();
  for (const bool is_second : {false, true})
  {
    Association half = half_of(scans, a, is_second);
    if (half.patches.empty()) return Vector::Ones();
    const Vector own = solve(scans, track, v, chosen, half);
    const auto information = gather_information(scans, track, own, half);
    variance += covariance_of(information, chosen).diagonal();
    difference += is_second ? own : Vector(-own);
  }
  Vector factor = Vector::Ones();
  for (int i = 0; i < kParameters; ++i)
    if (const double by = std::abs(difference[i]) / std::sqrt(variance[i]); std::isfinite(by))
      factor[i] = std::max(1.0, by);
  return factor;
}

}  // namespace talus::calibrate
