#pragma once
#include "kernels/config.h"

namespace talus::kernels
{
/** The rules that can be switched off in a build for the laboratory, by their numbers in rules.md.
 * Rules of the paper itself (7, 8, 22, 43) and the lines of a fill (32) have no switch. */
#define TALUS_RULES(RULE)      \
  RULE(kHeightBand, 1)         \
  RULE(kBodyBoxes, 2)          \
  RULE(kBuriedRays, 3)         \
  RULE(kFollowsPoses, 4)       \
  RULE(kGateOfBoth, 6)         \
  RULE(kHighHitStands, 9)      \
  RULE(kUnderRobot, 10)        \
  RULE(kPresumedStart, 11)     \
  RULE(kReach, 12)             \
  RULE(kRayBelowGround, 23)    \
  RULE(kLoneHits, 24)          \
  RULE(kOverhangStays, 27)     \
  RULE(kAsAWhole, 30)          \
  RULE(kLowestUnderObject, 35) \
  RULE(kProofOfFills, 40)      \
  RULE(kLowSteps, 45)          \
  RULE(kObstaclesGoOn, 46)     \
  RULE(kDropOffs, 47)

enum Rule : int
{
#define TALUS_RULE(name, number) name = number,
  TALUS_RULES(TALUS_RULE)
#undef TALUS_RULE
};
#define TALUS_RULE(name, number) name,
constexpr Rule kRules[]{TALUS_RULES(TALUS_RULE)};
#undef TALUS_RULE

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
