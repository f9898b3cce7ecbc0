#include "point_times.h"

#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace talus::import
{
namespace
{
constexpr double kSinceEpoch_s = 1e9, kMaxOff_s = 60;
}  // namespace

void PointClock::add(const ScanFile& scan, double time_s)
{
  constexpr double kBroken = 0.02;  // of the points
  if (scan.time.empty()) return;
  samples_.push_back(
      {io::quantile(scan.time, kBroken), io::quantile(scan.time, 1 - kBroken), time_s});
  estimate();
}

double PointClock::median_of(const std::function<double(const Sample&)>& value) const
{
  std::vector<double> values;
  for (const Sample& s : samples_)
    if (const double v = value(s); !std::isnan(v)) values.push_back(v);
  return io::quantile(std::move(values), 0.5);
}

/** Units are a factor of 1000 apart: the largest one in which no scan takes longer than its period
 * allows, and in which it begins near the time of the scan. */
void PointClock::estimate()
{
  constexpr double kLongestScan_s = 2, kMaxPeriods = 3;
  double period_s = period_s_;
  if (period_s == 0)
  {
    std::vector<double> all_s;
    for (std::size_t i = 1; i < samples_.size(); ++i)
      if (const double s = samples_[i].time_s - samples_[i - 1].time_s; s > 0) all_s.push_back(s);
    period_s = io::quantile(std::move(all_s), 0.5);
  }
  max_span_s_ =
      std::isnan(period_s) ? kLongestScan_s : std::min(kLongestScan_s, kMaxPeriods * period_s);
  const double span = median_of([](const Sample& s) { return s.high - s.low; });
  are_same_ = span == 0;
  unit_s_ = 0;
  for (const double unit_s : {1.0, 1e-3, 1e-6, 1e-9})
    if (span > 0 && span * unit_s <= max_span_s_ && begins_at_scans(unit_s))
      return void(unit_s_ = unit_s);
}

/** Sets what the times are since. */
bool PointClock::begins_at_scans(double unit_s)
{
  constexpr double kLatest_s = 1e10;  // the year 2286
  const auto since_s = [=](const Sample& s) { return s.low * unit_s; };
  const double median_s = median_of(since_s);
  const double size_s = median_of([&](const Sample& s) { return std::abs(since_s(s)); });
  const double off_s = median_of([&](const Sample& s) { return std::abs(since_s(s) - s.time_s); });
  is_since_epoch_ = median_s >= kSinceEpoch_s && median_s < kLatest_s;
  begin_s_ = 0;
  is_absolute_ = std::isnan(off_s) ? is_since_epoch_ : off_s < size_s;
  if (is_absolute_ && (std::isnan(off_s) || off_s <= max_span_s_)) return true;
  // Those since the start of a driver grow from scan to scan.
  const double changes_s =
      median_of([&](const Sample& s) { return std::abs(since_s(s) - median_s); });
  const double span_s = median_of([=](const Sample& s) { return (s.high - s.low) * unit_s; });
  if (!is_absolute_ && size_s <= kMaxOff_s && changes_s <= span_s / 2) return true;
  return is_absolute_ = size_s < kLatest_s && begins_elsewhere(unit_s);
}

/** Since midnight, the beginning of an hour or a GPS week, in another zone, or by the clock of GPS
 * or PTP, which know no leap seconds. */
bool PointClock::begins_elsewhere(double unit_s)
{
  constexpr double kZones_s = 900;  // zones, hours, days and weeks are multiples of it
  const auto ahead_s = [=](const Sample& s) { return s.low * unit_s - s.time_s; };
  for (const double leap_s : {0.0, 18.0, -18.0, 37.0, -37.0})
  {
    begin_s_ = leap_s + kZones_s * std::round((-leap_s + median_of(ahead_s)) / kZones_s);
    const double off_s =
        median_of([&](const Sample& s) { return std::abs(ahead_s(s) - begin_s_); });
    if (off_s <= max_span_s_) return true;
  }
  return false;
}

double PointClock::first_s(const ScanFile& scan) const
{
  if (scan.time.empty() || unit_s_ == 0) return std::nan("");
  return unit_s_ * *std::min_element(scan.time.begin(), scan.time.end()) - begin_s_;
}

std::size_t PointClock::leave_out_broken(ScanFile& scan) const
{
  constexpr std::size_t kMany = 10;  // one in this count
  const std::size_t points = scan.time.size();
  if (points == 0) return 0;
  if (unit_s_ == 0) return scan.time.clear(), 0;
  const double limit = max_span_s_ / unit_s_;
  const auto [first, last] = std::minmax_element(scan.time.begin(), scan.time.end());
  if (*last - *first <= limit) return 0;
  const double middle = io::quantile(scan.time, 0.5);
  std::vector<bool> is_kept(points);
  for (std::size_t i = 0; i < points; ++i) is_kept[i] = std::abs(scan.time[i] - middle) <= limit;
  const auto broken = static_cast<std::size_t>(std::count(is_kept.begin(), is_kept.end(), false));
  if (broken * kMany > points) return scan.time.clear(), 0;
  scan.keep(is_kept);
  return broken;
}

std::vector<float> PointClock::times_since(double time_s, const ScanFile& scan) const
{
  const double origin_s = is_absolute_ ? begin_s_ + time_s : 0;
  std::vector<float> times_s;
  times_s.reserve(scan.time.size());
  for (const double time : scan.time)
  {
    const double since_s = time * unit_s_ - origin_s;
    if (!(std::abs(since_s) <= kMaxOff_s)) return {};
    times_s.push_back(static_cast<float>(since_s));
  }
  return times_s;
}

std::string PointClock::remark() const
{
  if (is_understood())
    return begin_s_ == 0 || samples_.empty()
               ? ""
               : "its points have another clock than its scans: " + fixed_text(begin_s_, 0) +
                     " s are taken off their times";
  return std::string("its scans are read without times of points, and are not deskewed: ") +
         (are_same_ ? "these are the same for all points of a scan"
                    : "these fit no unit and no beginning");
}

}  // namespace talus::import
