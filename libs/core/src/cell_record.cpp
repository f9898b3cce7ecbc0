#include <talus/cell_record.h>
#include "kernels/cell.h"

#include <algorithm>

namespace talus
{
static_assert(kOtherFloor_m == kernels::kOtherFloor_m);

namespace
{
constexpr int kFlagsByte = 0;  // they come first, see TALUS_CELL_EVIDENCE
}

bool is_reached(const CellRecord& record)
{
  return (record.evidence[kFlagsByte] & kernels::kWasReached) != 0;
}
void set_reached(CellRecord& record) { record.evidence[kFlagsByte] |= kernels::kWasReached; }

void clear_transient_evidence(CellRecord& record)
{
  std::fill(record.evidence + CellRecord::kLastingBytes, std::end(record.evidence), 0);
}

}  // namespace talus
