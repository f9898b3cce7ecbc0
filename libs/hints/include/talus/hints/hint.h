#pragma once
#include <string>

namespace talus::hints
{
/** What is wrong with a log or its settings; causes before what they cause. */
enum class Kind
{
  UpsideDown,  //!< the robot, or its sensor, stands on its head
  TiltedGround,  //!< the ground that is seen leans by more than any ground does
  SensorInGround,  //!< rays begin in the ground
  TwoGrounds,  //!< two sensors see the ground at two heights, or leaning otherwise
  Mounting,  //!< the ground is not where the mounting says that the robot stands
  WrongAxes,  //!< walls fit where the poses are mirrored, swapped or turned
  Sideways,  //!< the robot drives sideways to its heading
  PoseJumps,  //!< the poses leap
  LevelPoses,  //!< the path climbs, and the poses stay level
  NotDeskewed,  //!< scans that are sweeps of a robot that turns fast
  LateClock,  //!< the stamps of the scans do not fit those of the poses
  Contradiction,  //!< scans see one place at several heights
  HeightBand,  //!< the points lie outside of min_height_m .. max_height_m
  Window,  //!< the points lie outside of the window
  LittleSeen,  //!< most of the window was not seen
  OwnBody,  //!< points move with the robot
  UnseenAhead,  //!< no ray ahead is as high as the robot
};

/** One line for a person: what was seen, with its figures, and the setting that mends it. */
struct Hint
{
  /** What it is about. */
  Kind kind;
  /** The line. */
  std::string text;
};

/** A parameter that suits a log, its value as set_parameter() reads it, and why: a few words with
 * the figures. */
struct Suggestion
{
  /** Of the parameter; text of the value; a few words. */
  std::string name, value, reason;
};

}  // namespace talus::hints
