#pragma once
#include <cstdint>
#include <vector>

namespace talus
{
/** The time of a frame relative to the earlier frames of the same sensor. */
enum class FrameOrder : int
{
  Newest,  //!< newer than all frames before
  Duplicate,  //!< it has the stamp of the newest frame
  Late,  //!< older than the newest frame, by max_late_s or less
  ClockSetBack  //!< older by more than that: a clock was set back
};

/** Compares the stamps of frames as they come, separately for each sensor. */
class FrameSequence
{
 public:
  /** Throws std::invalid_argument unless max_late_s is a number >= 0. */
  explicit FrameSequence(double max_late_s = 1.0);

  /** Judges the next frame of a sensor (Frame::sensor). After a clock was set back, time goes on
   * from the new stamp, so that a single wrong stamp in the future costs only its own frame. Throws
   * std::invalid_argument for a stamp [s] that is not finite. */
  FrameOrder next(double stamp_s, std::uint32_t sensor = 0);

 private:
  double max_late_s_;
  struct Newest
  {
    std::uint32_t sensor;
    double stamp_s;
  };
  std::vector<Newest> newest_;  //!< for each sensor that has sent a frame
};

}  // namespace talus
