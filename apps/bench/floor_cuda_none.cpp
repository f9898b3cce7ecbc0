#include "floor.h"

namespace talus::bench
{
std::optional<double> cuda_floor_s(const Load&) { return std::nullopt; }

}  // namespace talus::bench
