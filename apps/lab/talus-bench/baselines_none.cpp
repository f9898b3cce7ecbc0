#include "baselines.h"

namespace talus::bench
{
std::vector<Baseline> baselines() { return {}; }

}  // namespace talus::bench
