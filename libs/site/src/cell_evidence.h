#pragma once
#include <talus/layers.h>
#include <talus/site/tile_store.h>

#include <cmath>

namespace talus::site
{
inline bool is_measured(const SiteCell& s)
{
  return s.cell.state == static_cast<std::uint8_t>(CellState::Measured);
}
inline bool has_elevation(const SiteCell& s) { return !std::isnan(s.cell.elevation_m); }
/** Whether it tells if something stands there. */
inline bool has_seen(const SiteCell& s) { return is_measured(s) || has_elevation(s); }

}  // namespace talus::site
