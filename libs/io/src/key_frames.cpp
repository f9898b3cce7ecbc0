#include "key_frames.h"

#include <mrpt/containers/yaml.h>
#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/poses/CPose3DPDF.h>
#include <mrpt/poses/CPosePDF.h>
#include <mrpt/poses/Lie/SE.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>
#include <sstream>

#include "packed_file.h"

using mrpt::obs::CObservation;
using mrpt::poses::CPose3D;

namespace talus::io
{
namespace
{
constexpr const char* kVelocities = "local_velocity_buffer";  // of MOLA, in a comment

bool is_scan(const CObservation& obs)
{
  return dynamic_cast<const mrpt::obs::CObservationPointCloud*>(&obs) ||
         dynamic_cast<const mrpt::obs::CObservationVelodyneScan*>(&obs) ||
         dynamic_cast<const mrpt::obs::CObservationRotatingScan*>(&obs);
}

/** Stamps of the observations, that of the first scan first: a pose is of its time. */
std::vector<double> stamps_of(const mrpt::obs::CSensoryFrame& frame)
{
  std::vector<double> stamps_s;
  bool has_scan = false;
  for (const auto& obs : frame)
  {
    if (!obs || obs->timestamp == INVALID_TIMESTAMP) continue;
    const bool is_first_scan = is_scan(*obs) && !has_scan;
    stamps_s.insert(
        is_first_scan ? stamps_s.begin() : stamps_s.end(), mrpt::Clock::toDouble(obs->timestamp));
    has_scan = has_scan || is_first_scan;
  }
  return stamps_s;
}

/** Of those at the time nearest to 0, which is that of the scan: three numbers of "[x y z]". */
void add_nearest(const mrpt::containers::yaml& of, std::vector<double>& numbers)
{
  double least_s = HUGE_VAL;
  std::string text;
  for (const auto& [time, value] : of.asMap())
    if (const auto t = number_from(time.as<std::string>()); t && std::abs(*t) < least_s)
    {
      least_s = std::abs(*t);
      text = value.as<std::string>();
    }
  std::replace_if(
      text.begin(), text.end(), [](char c) { return std::strchr("'\"[],", c); }, ' ');
  std::istringstream words(text);
  for (std::string word; words >> word;) numbers.push_back(number_from(word).value_or(NAN));
}

/** What MOLA measured of the robot's motion around the scan. */
std::optional<KeyFrames::Twist> twist_told_by(const mrpt::obs::CSensoryFrame& frame)
{
  for (const auto& obs : frame)
  {
    const auto* comment = dynamic_cast<const mrpt::obs::CObservationComment*>(obs.get());
    if (!comment || comment->text.find(kVelocities) == std::string::npos) continue;
    std::vector<double> numbers;
    try
    {
      const auto text = mrpt::containers::yaml::FromText(comment->text);
      for (const char* of : {"linear_velocities", "angular_velocities"})
        add_nearest(text[kVelocities]["state"][of], numbers);
    }
    catch (const std::exception&)
    {
      continue;  // it says something else, or only one of the two
    }
    KeyFrames::Twist twist;
    if (numbers.size() == 6 && std::isfinite(std::accumulate(numbers.begin(), numbers.end(), 0.0)))
      return std::copy(numbers.begin(), numbers.end(), twist.begin()), twist;
  }
  return {};
}

/** By a motion that lasts: half of the turn, the way, the other half. */
CPose3D moved(const KeyFrames::Twist& twist, double time_s)
{
  const double half_s = time_s / 2;
  const auto half_turn = mrpt::poses::Lie::SE<3>::exp(
      KeyFrames::Twist({0.0, 0.0, 0.0, twist[3] * half_s, twist[4] * half_s, twist[5] * half_s}));
  const CPose3D along(twist[0] * time_s, twist[1] * time_s, twist[2] * time_s, 0, 0, 0);
  return half_turn + along + half_turn;
}
}  // namespace

KeyFrames::KeyFrames(mrpt::serialization::CArchive& in, int version, bool has_end_flag)
    : in_(in), version_(version), has_end_flag_(has_end_flag)
{
  constexpr int kNewest = 2;
  if (version < 0 || version > kNewest)
    throw std::runtime_error(
        "unknown serialization version " + std::to_string(version) + " of CSimpleMap");
  in_ >> count_;
}

KeyFrames::Frame KeyFrames::read_frame()
{
  Frame frame;
  ++read_;
  const std::string name =
      "is key frame " + std::to_string(read_) + " of " + std::to_string(count_) + ": ";
  const auto pose = in_.ReadObject();
  if (const auto in_plane = std::dynamic_pointer_cast<mrpt::poses::CPosePDF>(pose))
    frame.T_map_base = CPose3D(in_plane->getMeanVal());
  else if (const auto in_space = std::dynamic_pointer_cast<mrpt::poses::CPose3DPDF>(pose))
    frame.T_map_base = in_space->getMeanVal();
  else
    throw BadKeyFrame(name + "it has no pose. Delete it");
  if (!is_finite(frame.T_map_base))
    throw BadKeyFrame(name + "its pose is not finite. Delete key frames without a pose");
  frame.observations = in_.ReadObject<mrpt::obs::CSensoryFrame>();
  if (!frame.observations) throw BadKeyFrame(name + "it has no observations");
  frame.stamps_s = stamps_of(*frame.observations);
  frame.twist = twist_told_by(*frame.observations);
  if (version_ < 2) return frame;
  std::string optional, type;
  bool has_twist = false;
  in_ >> optional >> type >> has_twist;
  if (optional != "std::optional") throw BadKeyFrame(name + "no twist follows. It is damaged");
  if (has_twist) frame.twist.emplace();
  for (int i = 0; has_twist && i < 6; ++i) in_ >> (*frame.twist)[i];
  return frame;
}

void KeyFrames::read_end()
{
  constexpr std::uint8_t kEnd = 0x88;
  if (has_end_flag_ && in_.ReadAs<std::uint8_t>() != kEnd)
    throw std::runtime_error("what follows its key frames is not its end");
  if (last_stamp_s_ == -HUGE_VAL)
    throw BadKeyFrame(
        "is the last of " + std::to_string(count_) +
        " key frames, of which none has an observation with a time stamp: the poses belong to no "
        "time. Give the observations time stamps, or pass a TUM file");
}

mrpt::serialization::CSerializable::Ptr KeyFrames::next()
{
  if (objects_.empty())
  {
    const Frame frame = pending_ ? *pending_ : read_frame();
    const double before_s = last_stamp_s_;
    if (!frame.stamps_s.empty()) last_stamp_s_ = frame.stamps_s.front();
    pending_.reset();
    if (read_ < count_)
      pending_ = read_frame();
    else
      read_end();
    add_poses(frame, before_s);
    objects_.push_back(frame.observations);
  }
  auto object = objects_.front();
  objects_.pop_front();
  return object;
}

/** At the stamps of the frame, and around that of its scan as far as no neighbour is nearer. */
void KeyFrames::add_poses(const Frame& frame, double before_s)
{
  if (frame.stamps_s.empty()) return;
  const double at_s = frame.stamps_s.front();
  std::set<double> stamps_s(frame.stamps_s.begin(), frame.stamps_s.end());
  if (frame.twist)
  {
    const bool is_last = !pending_ || pending_->stamps_s.empty();
    const double after_s = is_last ? HUGE_VAL : pending_->stamps_s.front();
    for (const double from_s : {-0.2, -0.1, 0.1, 0.2})  // a sweep takes 0.05 to 0.2 s
      if (from_s > (before_s - at_s) / 2 && from_s < (after_s - at_s) / 2)
        stamps_s.insert(at_s + from_s);
  }
  for (const double stamp_s : stamps_s)
  {
    auto pose = mrpt::obs::CObservationRobotPose::Create();
    pose->sensorLabel = kKeyFrames;
    pose->timestamp = mrpt::Clock::fromDouble(stamp_s);
    pose->pose.mean = frame.T_map_base;
    if (frame.twist) pose->pose.mean = frame.T_map_base + moved(*frame.twist, stamp_s - at_s);
    objects_.push_back(pose);
  }
}

}  // namespace talus::io
