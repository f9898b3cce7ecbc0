#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace talus::import
{
/** Clocks are another where stamps are farther apart: localization stamps its transforms up to 1 s
 * ahead. */
constexpr double kOtherClock_s = 1.5;

/** How far stamps are from the times of recording, along a bag: of a long one not all. */
class StampOffsets
{
 public:
  /** In the order of recording. A stamp of 0 is none. `last_s`: of a scan, its last point after the
   * stamp. */
  void add(std::int64_t log_time_ns, std::int64_t stamp_ns, double last_s = 0);

  /** What scans with these offsets have to do with the clock of their poses. */
  struct Comparison
  {
    std::string warning;  //!< they have another one, one of the two jumps, or the scans were
                          //!< recorded before they were measured; else empty
    bool is_clock = false;  //!< and no delay, which would vary
    bool poses_are_recorded = false;  //!< the poses have the clock of the recorder
  };
  Comparison with(const StampOffsets& poses) const;

 private:
  struct Offset
  {
    std::int64_t log_time_ns = 0;
    double late_s = 0;  //!< the recording, after the stamp
    double last_s = 0;  //!< the last point, after the stamp
  };
  /** Where the two times differ most from one message to the next. */
  enum class Break
  {
    None,
    Jump,  //!< of the stamps
    Stall  //!< of the recording, which catches up afterwards
  };
  Break find_break() const;
  std::string before_measured(const StampOffsets& poses) const;
  double median_s(double Offset::*value) const;
  std::vector<Offset> all_;
  std::size_t step_ = 1, count_ = 0;  //!< each step_-th of count_ is kept
};

}  // namespace talus::import
