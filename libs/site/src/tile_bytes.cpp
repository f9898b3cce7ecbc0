#include <talus/site/tile_bytes.h>

#include "kept_cell.h"

#include <zstd.h>

#include <cstring>
#include <stdexcept>

namespace talus::site
{
namespace
{
constexpr int kFastest = 1;
constexpr std::size_t kTileSize = static_cast<std::size_t>(kTileCells) * kTileCells;

/** Calls f(memory of a value, its size) for all that a cell is made of, and for where it stands. */
template <class Cell, class Index, class F>
void for_each_value(Cell& cell, Index& index, const F& f)
{
  auto& c = cell.cell;
  f(&index, sizeof index);
  for (auto* v :
       {&c.ground_m, &c.ground_variance_m2, &c.elevation_m, &c.elevation_variance_m2,
        &c.traversability})
    f(v, sizeof *v);
  f(&c.state, sizeof c.state);
  f(&c.evidence, sizeof c.evidence);
  f(&cell.seen_s, sizeof cell.seen_s);
}
constexpr std::size_t kCellBytes = sizeof(std::uint16_t) + 5 * sizeof(float) + 1 +
                                   CellRecord::kEvidenceBytes + sizeof(std::uint32_t);

[[noreturn]] void fail() { throw std::invalid_argument("a tile of the whole map is damaged"); }
}  // namespace

std::vector<std::uint8_t> bytes_of(const Tile& tile)
{
  std::vector<std::uint8_t> plain;
  for (std::size_t i = 0; i < kTileSize; ++i)
  {
    if (!tile.cells[i].known()) continue;
    const auto index = static_cast<std::uint16_t>(i);
    for_each_value(
        tile.cells[i], index,
        [&](const void* from, std::size_t size)
        {
          const auto* first = static_cast<const std::uint8_t*>(from);
          plain.insert(plain.end(), first, first + size);
        });
  }
  std::vector<std::uint8_t> bytes(ZSTD_compressBound(plain.size()));
  const std::size_t size =
      ZSTD_compress(bytes.data(), bytes.size(), plain.data(), plain.size(), kFastest);
  if (ZSTD_isError(size)) throw std::runtime_error(ZSTD_getErrorName(size));
  bytes.resize(size);
  return bytes;
}

void read_tile(const std::vector<std::uint8_t>& bytes, Tile& tile)
{
  const auto size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size > kTileSize * kCellBytes || size % kCellBytes != 0) fail();  // also where it is unknown
  std::vector<std::uint8_t> plain(size);
  if (ZSTD_decompress(plain.data(), plain.size(), bytes.data(), bytes.size()) != size) fail();
  tile = {};
  const std::uint8_t* from = plain.data();
  for (int last = -1; from < plain.data() + plain.size();)
  {
    SiteCell cell;
    std::uint16_t index;
    for_each_value(
        cell, index,
        [&](void* to, std::size_t n)
        {
          std::memcpy(to, from, n);
          from += n;
        });
    if (index <= last || index >= kTileSize || !cell.known() || !is_sound(cell.cell)) fail();
    last = index;
    tile.cells[index] = cell;
  }
}

}  // namespace talus::site
