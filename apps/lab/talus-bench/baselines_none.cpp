#include "baselines.h"

namespace talus::bench
{
std::vector<Baseline> baselines() { return {}; }
std::vector<WholeDrive> whole_drives() { return {}; }

}  // namespace talus::bench
