#pragma once
// Every number that decides whether there is a hint. No hint is better than a false one: each lies
// well beyond what sound logs show (doc/hints.md has the figures).

namespace talus::hints
{
/// @name What is looked at
/// @{
constexpr std::size_t kFewPoints = 1024,
                      kManyPoints = 4096;  // of a frame, with little effort and with much
constexpr std::size_t kMaxNearPoints = 2048;  // that may be of the body, of a frame
constexpr double kNear_m = 1.5, kFar_m = 8;  // ground around the sensor, beyond the robot itself
constexpr double kFarther_m = 25;  // where a sensor high up sees none nearer: for suggestions only,
constexpr double kFartherShare = 0.3;  // with that part of the places in view on it
constexpr std::size_t kAllFrames = 4, kManyFrames = 64,
                      kSomeFrames = 512;  // then every 4th, 8th, 32nd
constexpr std::size_t kNoiseFrames = 3;  // whose every point is looked at
/// @}

/// @name The ground in the frame of the base
/// @{
constexpr double kGroundShare = 0.5;  // of the frames must show the plane that is judged
constexpr double kMinMounting_m = 0.25;  // a sensor lower than this does not show base from sensor
constexpr double kAtSensor_m = 0.15;  // "at the height of the sensor"
constexpr double kWrongHeight_m = 0.25;  // swells and kerbs around a robot: up to 0.22
constexpr double kWrongHeightOnce_m =
    0.5;  // of a log too short to separate where the robot stands from how it is mounted
constexpr double kSteadyHeight = 0.7;  // of it that three of four frames must show
constexpr double kWrongHeightShare = 0.15;  // of the height of the sensor: the same for cars
constexpr double kWrongTilt_deg = 7;  // against base and map: drives along a bank up to 4.1
constexpr std::size_t kMinGrounds =
    8;  // frames, and kMinBodyPath_m, before a tilt is the mounting's
constexpr double kTwoGrounds_m = 0.15, kTwoGrounds_deg = 6;  // both sensors look at the same places
constexpr double kTilted_deg = 20;  // what no robot drives on for half a log
constexpr double kUpsideDown = -0.5;  // z of the base's z axis in the map: turned by 120 degrees
/// @}

/// @name Rays that begin in the ground
/// @{
constexpr double kMuchFarther = 2;  // a ray from 0.1 m passes 5 cm above level ground half as far
constexpr double kOverGround_m = 0.02;  // above it: noise of a range
constexpr std::size_t kMinRayPairs = 30;  // of a frame
constexpr double kBuried = 0.1;  // of them: sound frames up to 0.03, also from 0.1 m above a field
/// @}

/// @name Poses
/// @{
constexpr double kJump_m = 0.3;  // off from where the speed so far leads
constexpr double kJump_mps2 = 15, kJumpUp_mps2 = 8;  // beyond what tyres and springs can do
constexpr double kJumpGap_s = 1;  // between frames farther apart speeds say little
constexpr double kTurn_deg = 20, kTurnGap_s = 0.3;  // the same of a turn
/// @}

/// @name Poses that climb and stay level
/// @{
constexpr double kSlopePiece_m = 1;  // of path, whose slope is compared with that of the poses
constexpr std::size_t kMinPieces = 5;
constexpr double kMinPathSlope_deg = 2.5;  // root mean square: less does not matter to the map
constexpr double kSlopeOverNoise = 3;
constexpr double kLevelPoses =
    0.3;  // of the slope of the path: sound poses lean by 0.8 or more of it
constexpr double kLevelGround = 0.5;  // a robot that levels its body sees ground that leans
constexpr double kFlat_m = 0.02, kFlat_deg = 0.1;  // poses of a plane
/// @}

/// @name Times of scans, by walls that are seen while the robot turns
/// @{
constexpr std::size_t kWallPoints = 6000, kFacets = 60;  // of a frame
constexpr double kMinTurn_rps = 0.2;
constexpr double kCalmStep_s = 2, kKeptStep_s = 0.5;  // between calm frames before turns, after
constexpr double kMaxApart_m = 0.3;  // walls; what is farther apart counts as that
constexpr double kMinCompared = 100;  // pieces of walls, each with one of another frame
constexpr double kMinWallsApart_m = 0.04;  // mean: sound drives up to 0.02
constexpr double kSweepFits = 0.6, kClockFits = 0.5;  // of that distance, with the lag taken off
constexpr double kMinSkew_deg = 4;  // turned during a sweep
constexpr double kMinLate_s = 0.03;
constexpr double kMaxLate_s = 0.4, kMaxGrown_s = 3;  // that is looked for
constexpr double kGrowthFits = 0.7;  // of the distance with one lag for all
/// @}

/// @name Axes of the poses, by directions of travel and by walls
/// @{
constexpr double kMinSidewaysPath_m = 5;
constexpr double kAlwaysSideways = 0.8;  // of the path, at one angle
constexpr double kMinSideways_deg = 30;  // vehicles that steer all wheels: less
constexpr double kMinWrongAxes_m = 0.08;  // walls apart, mean: sound drives up to 0.04
constexpr double kAxesFit = 0.5;  // of that distance, with other axes
constexpr double kMinMovedWalls_m = 0.15;  // of a robot that stands by its poses
constexpr double kMinClimb_m = 2;  // of a robot that would climb more than it drives
constexpr double kNoGround = 0.1;  // of the frames
constexpr std::size_t kMinNoGround = 10;  // frames
constexpr double kFastest_mps = 70;  // of robots and cars
constexpr double kMinTiltedFrame_deg = 3;  // of a mounting, by which the map is tilted, too
constexpr double kTiltedFrame = 0.5;  // of it, at least
constexpr double kBeginsLevel_deg = 1;  // first pose of a sensor whose frame is the map's
/// @}

/// @name Scans that contradict each other
/// @{
constexpr double kCell_m = 0.5;
constexpr int kMinHits = 3;  // of a cell in a frame: a mean and a spread
constexpr double kGroundBand_m = 0.3;  // of a frame's own ground plane: what is compared
constexpr double kContradictionReach_m = 10;
constexpr double kMinApart_m = 0.5;  // a robot that stood still repeats its errors
constexpr std::size_t kMinPairs = 100;
constexpr double kContradiction_m =
    0.03;  // median difference of two frames' means: sound logs up to 0.022
constexpr double kContradictionRatio = 3;  // of that to the spread within a frame and cell
/// @}

/// @name The robot's own body
/// @{
constexpr double kBodyReach_m = 3;  // a car seen from its roof
constexpr double kBodyVoxel_m = 0.1, kMapVoxel_m = 0.2;
constexpr double kBodyStep_m = 0.25;  // driven between two frames that count
constexpr int kBodyFrames = 64, kMinBodyFrames = 10;
constexpr double kMinBodyPath_m = 3;
constexpr double kBodyAbove_m = 0.2;  // lower points may be ground
constexpr double kVoxelShare = 0.5, kPartShare = 0.9;  // of the frames that hit a voxel, a part
constexpr double kMaxPersisting = 0.2;  // of the places of a part where something stays
constexpr double kReachHeights = 1.25;  // of the sensor, from it: cars up to 1.15
constexpr double kMinReach_m = 0.8;  // of a robot whose sensor is low
constexpr double kMaxGroundBefore = 0.2;  // of the frames that see ground before a part
constexpr double kMinBodyTurn_deg = 15;  // between the headings of a drive
constexpr double kMaxShift_m =
    0.07;  // of a part between two directions of travel: cars up to 0.063
/// @}

/// @name What lies above all rays
/// @{
constexpr double kLooksAhead_m = 1;  // of the base: what is farther must be seen
constexpr double kAheadCosine = 0.99;  // of 8 degrees: what is ahead
constexpr double kLooksDown = 0.052;  // slope of 3 degrees: level beams lie 2 degrees apart
/// @}

/// @name What reaches the map
/// @{
constexpr double kMajority = 0.5;  // "most points"
constexpr double kOutside =
    0.9;  // of the points in the band: far walls and fields are beyond any window, up to 0.8
// From the robot to the border, in heights of the sensor: nearer is little but the blind spot below
// it.
constexpr double kMinHeights = 2.5;
constexpr double kMaxHeights = 7;  // beyond it beams graze the ground at less than 8 degrees
constexpr double kOnGround_m = 0.1;  // of the plane: what is ground and not the foot of a wall
constexpr double kHardlyAny = 0.02;  // of the points on it
constexpr double kGroundAtBorder = 1;  // of half the window
constexpr double kBeyondNearest = 1.5;  // of the nearest ground: a window that shows some of it
constexpr double kKnownInside = 0.3;  // of a window large enough, at least
constexpr double kSeen = 0.1;  // of the window, at least
/// @}

}  // namespace talus::hints
