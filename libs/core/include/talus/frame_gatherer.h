#pragma once
#include <talus/frame.h>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace talus
{
/** Makes scans of what drivers send in small parts: packets, or the hundred frames a second of a
 * scanner without a pattern that repeats.
 *
 * The map counts evidence once a frame, and asks the rays of a frame what they passed. Both need
 * the rays of a whole scan: a tenth of one passes where the rest hits. So frames of a sensor that
 * come less than kApart_s apart are gathered for about kScan_s, each point with the time and the
 * pose of its part (Frame::path). Other frames are passed on as they are: so are those without a
 * time, whose stamps are all the same. */
class FrameGatherer
{
 public:
  /** Parts of a scan are closer in time than this [s]; at 20 turns a second scans come whole. */
  static constexpr double kApart_s = 0.04;
  /** The time of a scan [s]; the number of its parts is rounded. */
  static constexpr double kScan_s = 0.1;
  /** Takes a scan, which is valid only during the call. */
  using Take = std::function<void(const Frame&)>;

  /** Takes the next frame of its sensor, copies its points if it is a part of a scan, and passes on
   * what is complete: none, one or two scans. A scan of parts has the stamp, pose and mounting of
   * its last part. Throws std::invalid_argument for a part with points but without x_m, y_m or z_m;
   * what `take` throws ends the call, and its scan is gone. */
  void add(const Frame& frame, const Take& take);
  /** Passes on what is gathered so far, of each sensor: at the end of a log. */
  void finish(const Take& take);

 private:
  /** The parts of a scan of one sensor, and the scan that is made of them. */
  struct Parts
  {
    std::uint32_t sensor = 0;
    double newest_s = 0, passed_on_s = 0;  //!< stamps of its last frame, and of the last scan
    double apart_s = 0;  //!< between its last two parts; 0: it sends whole scans
    int count = 0;  //!< gathered parts
    double first_s = 0;  //!< stamp of the first of them; times count from there
    std::vector<float> x_m, y_m, z_m, time_s;
    std::array<std::vector<float>, kMaxChannels> channels;  //!< empty: no part has values
    Frame scan;
  };
  Parts& parts_of(std::uint32_t sensor);
  static void append(Parts& parts, const Frame& frame);
  static void pass_on(Parts& parts, const Take& take);

  std::vector<Parts> parts_;  //!< of each sensor
};

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
