#pragma once
#include <cstdint>
#include <vector>

namespace talus
{
/** How a frame stands in time to those of the same sensor that came before it. */
enum class FrameOrder : int
{
  Newest,  //!< the rule
  Duplicate,  //!< the stamp of the newest frame once more
  Late,  //!< older than the newest frame, by max_late_s or less
  ClockSetBack  //!< older by more than that: so late is no frame, but a clock was set
};

/** Judges frames as they come, by their stamps, those of each sensor by themselves. */
class FrameSequence
{
 public:
  /** Throws std::invalid_argument unless max_late_s is a number >= 0. */
  explicit FrameSequence(double max_late_s = 1.0);

  /** Takes note of the next frame, of the sensor with that number (Frame::sensor). After a clock
   * was set back, time goes on from its stamp; so a single wrong stamp in the future costs nothing
   * but itself. Throws std::invalid_argument for a stamp [s] that is not finite. */
  FrameOrder next(double stamp_s, std::uint32_t sensor = 0);

 private:
  double max_late_s_;
  struct Newest
  {
    std::uint32_t sensor;
    double stamp_s;
  };
  std::vector<Newest> newest_;  //!< of each sensor that has sent a frame
};

}  // namespace talus
