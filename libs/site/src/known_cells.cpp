#include "known_cells.h"

#include <algorithm>

namespace talus::site
{
void CellBox::add(std::int64_t x, std::int64_t y)
{
  min_x = std::min(min_x, x);
  max_x = std::max(max_x, x);
  min_y = std::min(min_y, y);
  max_y = std::max(max_y, y);
}

void CellBox::add(const CellBox& other)
{
  min_x = std::min(min_x, other.min_x);
  max_x = std::max(max_x, other.max_x);
  min_y = std::min(min_y, other.min_y);
  max_y = std::max(max_y, other.max_y);
}

CellBox known_box(Site& site, int floor)
{
  CellBox box;
  for_each_known(
      site, floor, [&](std::int64_t x, std::int64_t y, const SiteCell&) { box.add(x, y); });
  return box;
}

}  // namespace talus::site
