#pragma once
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>
#include <stdexcept>
#include <vector>

namespace talus::io
{
/** What the poses of a simplemap are called. */
constexpr const char* kKeyFrames = "key frames";

/** What is wrong with a key frame, after "the object at byte N". */
struct BadKeyFrame : std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/** The key frames of a simplemap, read one at a time: what a log would have of them. Also of newer
 * versions of MRPT, whose key frames have a twist. */
class KeyFrames
{
 public:
  /** After the header of a CSimpleMap of that version. */
  KeyFrames(mrpt::serialization::CArchive& in, int version, bool has_end_flag);

  /** How many the map has. */
  std::uint32_t count() const { return count_; }
  /** Whether all has been read. */
  bool at_end() const { return objects_.empty() && !pending_ && read_ == count_; }

  /** Robot poses at the stamps of a frame's observations, and, where it has a twist (of MRPT, or
   * MOLA's velocity buffer), shortly before and after them; then the frame. There is one more.
   * Throws BadKeyFrame, and what MRPT throws. */
  mrpt::serialization::CSerializable::Ptr next();

  using Twist = mrpt::math::CVectorFixedDouble<6>;  //!< linear and angular, frame of the base

 private:
  struct Frame
  {
    mrpt::poses::CPose3D T_map_base;
    mrpt::obs::CSensoryFrame::Ptr observations;
    std::optional<Twist> twist;
    std::vector<double> stamps_s;  //!< of the observations; first that of the pose
  };
  Frame read_frame();
  void read_end();
  void add_poses(const Frame& frame, double before_s);

  mrpt::serialization::CArchive& in_;
  int version_;
  bool has_end_flag_;
  std::uint32_t count_ = 0, read_ = 0;
  std::optional<Frame> pending_;
  double last_stamp_s_ = -HUGE_VAL;  //!< of the frame before
  std::deque<mrpt::serialization::CSerializable::Ptr> objects_;
};

}  // namespace talus::io
