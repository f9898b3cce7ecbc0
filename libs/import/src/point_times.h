#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "point_fields.h"

namespace talus::import
{
/** The unit and the beginning of the times of points of one sensor, estimated from several of its
 * scans: a few broken times decide nothing. */
class PointClock
{
 public:
  /** A scan, before any other use. `time_s`: NaN where it is not known yet. */
  void add(const ScanFile& scan, double time_s);

  /** Seconds from scan to scan; without it those between the scans that were added. */
  void set_period(double period_s)
  {
    period_s_ = period_s;
    estimate();
  }

  bool empty() const { return samples_.empty(); }
  /** Whether the times are seconds since 1970 in some unit. */
  bool is_since_epoch() const { return is_since_epoch_; }
  /** The earliest time of a scan [s]; NaN without. Of leave_out_broken() scans. */
  double first_s(const ScanFile& scan) const;

  /** Leaves out points whose time is far from those of their scan, and all times where these are
   * many or the clock is not understood. Returns the number of points. */
  std::size_t leave_out_broken(ScanFile& scan) const;
  /** The times of points relative to that of the scan [s]; empty where they are too far from it. */
  std::vector<float> times_since(double time_s, const ScanFile& scan) const;

  /** Why no scan has times of points, or what was assumed of them, for a sentence that begins with
   * the sensor. */
  std::string remark() const;
  bool is_understood() const { return samples_.empty() || unit_s_ > 0; }

 private:
  struct Sample
  {
    double low, high;  //!< of nearly all points, in the unit of the file
    double time_s;
  };
  void estimate();
  bool begins_at_scans(double unit_s);
  bool begins_elsewhere(double unit_s);
  double median_of(const std::function<double(const Sample&)>& value) const;

  std::vector<Sample> samples_;
  double period_s_ = 0;  //!< 0: nobody said it
  double unit_s_ = 0;  //!< 0: not understood
  double max_span_s_ = 0;  //!< no scan takes longer
  double begin_s_ = 0;  //!< of absolute times, since that of the times of scans
  bool is_since_epoch_ = false;
  bool is_absolute_ = false;
  bool are_same_ = false;  //!< all of a scan
};

}  // namespace talus::import
