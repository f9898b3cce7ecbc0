#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace talus::import
{
/** How far stamps are from the times of recording, along a bag: of a long one not all. */
class StampOffsets
{
 public:
  /** In the order of recording. A stamp of 0 is none. */
  void add(std::int64_t log_time_ns, std::int64_t stamp_ns);

  /** What is wrong where scans with these offsets have another clock than `poses`, or one of the
   * two jumps; else empty. */
  std::string warning_of_clock(const StampOffsets& poses) const;

 private:
  struct Offset
  {
    std::int64_t log_time_ns = 0;
    double late_s = 0;  //!< the recording, after the stamp
  };
  std::vector<Offset> all_;
  std::size_t step_ = 1, count_ = 0;  //!< each step_-th of count_ is kept
};

}  // namespace talus::import
