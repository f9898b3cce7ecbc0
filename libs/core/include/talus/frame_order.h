#pragma once

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

/** Judges frames as they come, by their stamps. */
class FrameSequence
{
 public:
  /** Throws std::invalid_argument unless max_late_s is a number >= 0. */
  explicit FrameSequence(double max_late_s = 1.0);

  /** Takes note of the next frame. After a clock was set back, time goes on from its stamp; so a
   * single wrong stamp in the future costs nothing but itself. Throws std::invalid_argument for a
   * stamp [s] that is not finite. */
  FrameOrder next(double stamp_s);

 private:
  double max_late_s_;
  double newest_s_ = 0;
  bool started_ = false;
};

}  // namespace talus
