#include "tile_pack.h"

#include <cstring>
#include <new>
#include <stdexcept>

namespace talus::site
{
namespace
{
constexpr int kPackLevel = 1;  //!< of zstd: the fastest
constexpr std::size_t kCells = std::size_t{kTileCells} * kTileCells;
constexpr std::size_t kValue = sizeof(std::uint32_t), kValues = sizeof(SiteCell) / kValue;
static_assert(kCells * kValues * kValue == sizeof(Tile));

/** f(which of values_, where it lies in a tile [bytes]). */
template <class F>
void for_each_word(const F& f)
{
  for (std::size_t value = 0; value < kValues; ++value)
    for (std::size_t cell = 0; cell < kCells; ++cell)
      f(value * kCells + cell, (cell * kValues + value) * kValue);
}
}  // namespace

TilePacker::TilePacker()
    : compressor_(ZSTD_createCCtx(), ZSTD_freeCCtx), values_(kCells * kValues), packed_(kMaxPacked)
{
  if (!compressor_) throw std::bad_alloc();
  ZSTD_CCtx_setParameter(compressor_.get(), ZSTD_c_compressionLevel, kPackLevel);
  ZSTD_CCtx_setParameter(compressor_.get(), ZSTD_c_checksumFlag, 1);
}

std::vector<std::uint8_t> TilePacker::pack_bytes(const char* tile)
{
  for_each_word([&](std::size_t i, std::size_t at)
                { std::memcpy(&values_[i], tile + at, kValue); });
  const std::size_t size = ZSTD_compress2(
      compressor_.get(), packed_.data(), packed_.size(), values_.data(), sizeof(Tile));
  if (ZSTD_isError(size)) throw std::runtime_error(ZSTD_getErrorName(size));
  return {packed_.data(), packed_.data() + size};
}

void TilePacker::unpack_bytes(const std::vector<std::uint8_t>& packed, char* tile)
{
  const std::size_t size =
      ZSTD_decompress(values_.data(), sizeof(Tile), packed.data(), packed.size());
  if (size != sizeof(Tile)) throw std::runtime_error("it is damaged");  // or an error of zstd
  for_each_word([&](std::size_t i, std::size_t at)
                { std::memcpy(tile + at, &values_[i], kValue); });
}

}  // namespace talus::site
