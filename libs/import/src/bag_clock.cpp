#include "bag_clock.h"

#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

namespace talus::import
{
namespace
{
/** Without the sign of what is rounded to zero. */
std::string seconds_text(double s) { return fixed_text(std::round(s * 100) / 100 + 0.0, 2); }

/** "0.02 s", or "0.02 to 37.02 s". */
std::string span_text(const std::vector<double>& values_s, bool is_one)
{
  const auto [least, most] = std::minmax_element(values_s.begin(), values_s.end());
  if (is_one) return seconds_text(io::quantile(values_s, 0.5)) + " s";
  return seconds_text(*least) + " to " + seconds_text(*most) + " s";
}
}  // namespace

void StampOffsets::add(std::int64_t log_time_ns, std::int64_t stamp_ns, double last_s)
{
  constexpr std::size_t kMax = 8192;
  if (stamp_ns == 0 || count_++ % step_ != 0) return;
  all_.push_back({log_time_ns, static_cast<double>(log_time_ns - stamp_ns) * 1e-9, last_s});
  if (all_.size() < kMax) return;
  for (std::size_t i = 0; i < kMax / 2; ++i) all_[i] = all_[2 * i];
  all_.resize(kMax / 2);
  step_ *= 2;
}

StampOffsets::Break StampOffsets::find_break() const
{
  std::vector<double> steps_s;  // of the stamps
  double most_s = kOtherClock_s / 2, log_step_s = 0, stamp_step_s = 0;
  for (std::size_t i = 1; i < all_.size(); ++i)
  {
    const double by_log_s =
        static_cast<double>(all_[i].log_time_ns - all_[i - 1].log_time_ns) * 1e-9;
    const double late_s = all_[i].late_s - all_[i - 1].late_s;
    steps_s.push_back(by_log_s - late_s);
    if (std::abs(late_s) <= most_s) continue;
    most_s = std::abs(late_s);
    log_step_s = by_log_s;
    stamp_step_s = steps_s.back();
  }
  if (log_step_s == stamp_step_s) return Break::None;
  const double usual_s = io::quantile(std::move(steps_s), 0.5);
  return std::abs(stamp_step_s - usual_s) < std::abs(log_step_s - usual_s) ? Break::Stall
                                                                           : Break::Jump;
}

double StampOffsets::median_s(double Offset::*value) const
{
  std::vector<double> all;
  for (const Offset& offset : all_) all.push_back(offset.*value);
  return io::quantile(std::move(all), 0.5);
}

/** A scan is recorded after its last point, by one clock and with the stamp of the first. */
std::string StampOffsets::before_measured(const StampOffsets& poses) const
{
  constexpr double kEarly_s = 0.05, kExactly_s = 1e-3;  // the stamps are the times of recording
  const double late_s = median_s(&Offset::late_s), last_s = median_s(&Offset::last_s),
               poses_s = poses.median_s(&Offset::late_s);
  const double early_s = std::min(0.0, poses_s) - (late_s - last_s);
  const bool is_judged = std::abs(poses_s) <= kOtherClock_s && std::abs(late_s) >= kExactly_s;
  if (!is_judged || early_s <= kEarly_s) return "";
  return "its scans were recorded " + seconds_text(last_s - late_s) +
         " s before their last points, the poses " + seconds_text(poses_s) +
         " s after their stamps (medians): the stamps are not those of the first points, or of "
         "another clock";
}

/** Compared where both were recorded, as the clock of a simulation runs slower than the recorder's:
 * medians of parts of the bag, which stand messages that were recorded late. */
StampOffsets::Comparison StampOffsets::with(const StampOffsets& poses) const
{
  constexpr double kVaries_s = 0.3;
  constexpr std::size_t kMinPerPart = 5, kMaxParts = 8;
  if (all_.empty() || poses.all_.empty()) return {};
  const auto before = [](const Offset& a, const Offset& b)
  { return a.log_time_ns < b.log_time_ns; };
  const std::size_t parts = std::clamp<std::size_t>(all_.size() / kMinPerPart, 1, kMaxParts);
  std::vector<double> scans_s, poses_s, apart_s;
  std::size_t steady = 0;  // parts
  for (std::size_t part = 0; part < parts; ++part)
  {
    std::vector<double> of_scans, of_poses, apart;
    for (auto i = part * all_.size() / parts; i < (part + 1) * all_.size() / parts; ++i)
    {
      const auto pose = std::lower_bound(poses.all_.begin(), poses.all_.end(), all_[i], before);
      of_scans.push_back(all_[i].late_s);
      of_poses.push_back((pose == poses.all_.end() ? poses.all_.back() : *pose).late_s);
      apart.push_back(of_scans.back() - of_poses.back());
    }
    const double varies_s = io::quantile(of_scans, 0.9) - io::quantile(of_scans, 0.1);
    steady += varies_s <= kVaries_s ? 1 : 0;
    scans_s.push_back(io::quantile(of_scans, 0.5));
    poses_s.push_back(io::quantile(of_poses, 0.5));
    apart_s.push_back(io::quantile(apart, 0.5));
  }
  const auto [least, most] = std::minmax_element(apart_s.begin(), apart_s.end());
  Comparison found;
  if (std::max(std::abs(*least), std::abs(*most)) <= kOtherClock_s)
  {
    found.warning = before_measured(poses);
    return found;
  }
  const bool is_one = *most - *least <= kOtherClock_s;
  const Break of_scans = find_break(), of_poses = poses.find_break();
  const bool stalls = of_scans == Break::Stall || of_poses == Break::Stall,
             jumps = of_scans == Break::Jump || of_poses == Break::Jump;
  if (!is_one && stalls && !jumps && std::min(std::abs(*least), std::abs(*most)) <= kOtherClock_s)
    return {};
  found.warning = std::string("its scans have another clock than the poses") +
                  (is_one ? "" : ", and one of the two jumps") + ": they were recorded " +
                  span_text(scans_s, is_one) + " after their stamps, the poses " +
                  span_text(poses_s, is_one) + " after theirs (medians)";
  found.is_clock = steady + 1 >= parts && 2 * steady > parts;
  found.poses_are_recorded = std::all_of(
      poses_s.begin(), poses_s.end(), [](double s) { return std::abs(s) <= kOtherClock_s; });
  return found;
}

}  // namespace talus::import
