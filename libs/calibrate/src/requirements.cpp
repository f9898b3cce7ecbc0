#include <talus/calibrate/information.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus::calibrate
{
namespace
{
constexpr int kFramesNeeded = 8;
constexpr double kMinExtent_m = 0.5, kMinTurn_rad = 0.2;
constexpr std::size_t kPatchesNeeded = 20;

std::string number(double v) { return fixed_text(v, 2); }
}  // namespace

void require_motion(const ScanSet& scans, const PoseTrack& track)
{
  int frames = 0;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(HUGE_VAL), high = -low;
  double turn_rad = 0;
  Eigen::Matrix3d first = Eigen::Matrix3d::Identity();
  for (int f = 0; f < scans.frames(); ++f)
  {
    if (!track.covers(scans.stamp_s(f))) continue;
    const TrackPose pose = track.at(scans.stamp_s(f));
    if (frames++ == 0) first = pose.R;
    low = low.cwiseMin(pose.t_m);
    high = high.cwiseMax(pose.t_m);
    turn_rad = std::max(turn_rad, Eigen::AngleAxisd(first.transpose() * pose.R).angle());
  }
  if (frames < kFramesNeeded)
    throw std::runtime_error(
        "has " + std::to_string(frames) + (frames == 1 ? " frame" : " frames") +
        " with a pose, too few to compare: the ground must be seen from several places. Record at "
        "least " +
        std::to_string(kFramesNeeded) + " frames, better 200, while the robot drives");
  const double extent_m = (high - low).norm();
  if (extent_m < kMinExtent_m && turn_rad < kMinTurn_rad)
    throw std::runtime_error(
        "shows no motion: the robot stays within " + number(extent_m) + " m and turns by " +
        number(turn_rad * 57.29578) +
        " degrees, so that all frames see the ground alike and nothing can be estimated from their "
        "differences. Drive some metres, with turns");
}

void require_ground(const Association& a)
{
  if (a.patches.size() >= kPatchesNeeded) return;
  throw std::runtime_error(
      "shows no ground that could be used: " + std::to_string(a.patches.size()) +
      " even patches were found that three or more frames see, " + std::to_string(kPatchesNeeded) +
      " are needed. Is the ground in the sensor's view and within --max-range, is the given "
      "mounting right to about 5 degrees, is --base-height the height of the trajectory's "
      "reference point above the ground?");
}

}  // namespace talus::calibrate
