#pragma once
#include <array>
#include <cstdint>

namespace talus
{
/** Why a point of a frame did not reach the map. */
enum class Reject : int
{
  NotFinite = 0,
  Range,  //!< nearer than min_range_m (also zero-range returns) or farther than max_range_m
  Height,  //!< outside the height band
  Body,  //!< the robot itself
  Outside,  //!< beyond the window
  Voxel,  //!< another point of the same voxel stands for it
  Buried,  //!< its ray would have passed under seen ground: a reflection
};
constexpr int kRejectCount = 7;
constexpr std::array<const char*, kRejectCount> kRejectNames{
    "not_finite", "range", "height", "body", "outside", "voxel", "buried"};

/** The stages of a frame, in their order. */
enum class Stage : int
{
  Accept = 0,  //!< points to the map frame, their tests and variances
  Roll,  //!< the window follows the robot
  Update,  //!< points into their cells
  Classify,  //!< ground, object, or to be filled
  CleanUp,  //!< removes objects that have left
  Fill,  //!< ground that was not measured
  Traversability,
};
constexpr int kStageCount = 7;
constexpr std::array<const char*, kStageCount> kStageNames{
    "accept", "roll", "update", "classify", "cleanup", "fill", "traversability"};

/** The result of one frame. */
struct FrameReport
{
  double stamp_s = 0;  //!< stamp of the frame [s]
  std::uint32_t points_in = 0;  //!< the number of its points
  /** The points that reached the map: points_in without all rejected ones. */
  std::uint32_t points_accepted = 0;
  std::array<std::uint32_t, kRejectCount> rejected{};  //!< indexed by Reject
  /** Whether it showed another floor than the map: all cells start empty in the next frame. */
  bool leaves_floor = false;
  /** Time of each Stage [ms]. On a device Roll runs within Accept and is a part of its time. */
  std::array<double, kStageCount> stage_ms{};
  double total_ms = 0;  //!< time of update() [ms]; on CUDA from start() to the end of finish()
};

}  // namespace talus
