#include <talus/mrpt/planner_ini.h>

#include <mrpt/system/string_utils.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/mrpt/version_compat.h>

#include <string>
#include <vector>

namespace talus
{
void fit_planner_ini(mrpt::config::CConfigFileBase& ini)
{
  const std::string section = "CHolonomicFullEval";
  for (const std::string key : {"factorWeights", "factorNormalizeOrNot"})
  {
    std::vector<std::string> factors;
    mrpt::system::tokenize(ini_value(ini, section, key), "[], \t", factors);
    if (factors.size() != 7 && factors.size() != 8) continue;
    factors.resize(detail::kHolonomicFactors, "0");
    std::string text;
    for (const auto& factor : factors) text += (text.empty() ? "[" : ", ") + factor;
    ini.write(section, key, text + "]");
  }
}

}  // namespace talus
