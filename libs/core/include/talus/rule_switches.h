#pragma once
#include <vector>

namespace talus
{
/** The environment variable that names the rules that are left out of maps, such as "27,30". Only a
 * build with -DTALUS_RULE_SWITCHES=ON looks at it. */
constexpr const char* kWithoutRulesVariable = "TALUS_WITHOUT_RULES";

/** The numbers (kernels/rules.md) of the rules that this build can leave out, in rising order.
 * Empty in a build without -DTALUS_RULE_SWITCHES=ON. */
std::vector<int> switchable_rules();

}  // namespace talus
