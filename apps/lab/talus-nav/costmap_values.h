#pragma once
#include <cmath>

namespace talus::nav
{
// What the cells of a costmap mean, which costmap_from_map() makes: probabilities of being free.
constexpr float kStandsBelow = 0.075F;  //!< in cells of less than this something stands
/** Cells that are known to be blocked though nothing stands there. */
constexpr float kEdge = 0.15F;
inline bool is_known_edge(float p) { return std::abs(p - kEdge) < 0.025F; }
/** What of this or more is blocked lies beside something that stands. */
constexpr float kBesideAbove = 0.225F;
constexpr float kBlockedUpTo = 0.45F;  //!< cells of this or less are blocked
/** Where nothing is known a way may be hoped for. What is known and not blocked is 0.55 or more. */
constexpr float kHopeful = 0.5F;

}  // namespace talus::nav
