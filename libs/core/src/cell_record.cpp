#include <talus/cell_record.h>
#include "kernels/cell.h"

#include <algorithm>

namespace talus
{
static_assert(kOtherFloor_m == kernels::kOtherFloor_m);

void forget_latest(CellRecord& record)
{
  std::fill(record.evidence + CellRecord::kLastingBytes, std::end(record.evidence), 0);
}

}  // namespace talus
