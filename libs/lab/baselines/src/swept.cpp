#include "cell_hits.h"

#include <talus/site/site_mapper.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>

namespace talus::baselines
{
namespace
{
constexpr std::size_t kMemory_bytes = std::size_t{512} << 20;

/** Drives once more, and keeps what leaves the window. */
void keep_drive(site::Site& site, const Sequence& sequence, const Parameters& parameters)
{
  site::SiteMapper mapper(site);
  ElevationMapper map(parameters, Backend::Cpu, 1);
  for (const ScanFrame& frame : sequence.frames) mapper.update(map, frame.view());
  mapper.keep_window(map);
  mapper.look_back(map);
}
}  // namespace

Share swept_blocked(const Sequence& sequence, const LabelMap& labels, const Parameters& parameters)
{
  Share blocked;
  const auto& all = *labels.stack.find("label");
  if (std::find(all.begin(), all.end(), static_cast<float>(LabelMap::kMoves)) == all.end())
    return blocked;
  site::Site site(
      parameters.resolution_m, kMemory_bytes, std::filesystem::temp_directory_path().string());
  keep_drive(site, sequence, parameters);
  const auto label_of = [&](std::int64_t x, std::int64_t y)
  {
    const auto middle_m = [&](std::int64_t cell)
    { return site::middle_of_cell_m(cell, parameters.resolution_m); };
    const std::ptrdiff_t at = labels.cell_at(middle_m(x), middle_m(y));
    return at < 0 ? LabelMap::kNotKnown : labels.label(at);
  };
  for (const site::TileKey& key : site.tiles.keys())
  {
    const auto& cells = site.tiles.find(key)->cells;
    for (std::size_t i = 0; i < cells.size(); ++i)
    {
      const auto at = static_cast<std::int64_t>(i);
      const std::int64_t x = site::cell_of_tile(key.x, at % site::kTileCells);
      const std::int64_t y = site::cell_of_tile(key.y, at / site::kTileCells);
      if (cells[i].known() && label_of(x, y) == LabelMap::kMoves)
        blocked.add(cells[i].cell.traversability == 0);
    }
  }
  return blocked;
}

}  // namespace talus::baselines
