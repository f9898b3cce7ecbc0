#pragma once
#include "kernels/config.h"

namespace talus::kernels
{
/** The rules that can be switched off in a build for the laboratory, by their numbers in rules.md.
 * Rules of the paper itself (7, 8, 22, 43) and the lines of a fill (32) have no switch. */
enum Rule : int
{
  kHeightBand = 1,
  kBodyBoxes = 2,
  kBuriedRays = 3,
  kFollowsPoses = 4,
  kGateOfBoth = 6,
  kHighHitStands = 9,
  kUnderRobot = 10,
  kPresumedStart = 11,
  kReach = 12,
  kRayBelowGround = 23,
  kLoneHits = 24,
  kOverhangStays = 27,
  kAsAWhole = 30,
  kLowestUnderObject = 35,
  kProofOfFills = 40,
  kLowSteps = 45,
  kObstaclesGoOn = 46,
  kDropOffs = 47
};

constexpr Rule kRules[]{
    kHeightBand, kBodyBoxes,         kBuriedRays,   kFollowsPoses,   kGateOfBoth,    kHighHitStands,
    kUnderRobot, kPresumedStart,     kReach,        kRayBelowGround, kLoneHits,      kOverhangStays,
    kAsAWhole,   kLowestUnderObject, kProofOfFills, kLowSteps,       kObstaclesGoOn, kDropOffs};

/** Whether a rule counts: all do, unless a build for the laboratory switches some off, or leaves
 * one out when it is compiled, to count what the rule costs. */
#if defined(TALUS_RULE_SWITCHES)
TALUS_HD bool on(Rule rule, const Config& k) { return (k.rules_off >> rule & 1) == 0; }
#elif defined(TALUS_WITHOUT_RULE)
TALUS_HD constexpr bool on(Rule rule, const Config&) { return rule != TALUS_WITHOUT_RULE; }
#else
TALUS_HD constexpr bool on(Rule, const Config&) { return true; }
#endif

}  // namespace talus::kernels
