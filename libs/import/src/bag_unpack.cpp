#include "bag_unpack.h"

#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

#include "bag_file.h"

namespace talus::import
{
namespace
{
using Stream = std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)>;

void unpack_zstd(std::string_view packed, std::optional<std::size_t> size, std::vector<char>& out)
{
  const Stream stream(ZSTD_createDStream(), ZSTD_freeDStream);
  if (!stream) throw std::bad_alloc();
  const std::size_t most = size.value_or(kMostBagBytes);
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  std::size_t done = 0;
  for (bool is_whole = false; !is_whole && !(size && done == *size);)
  {
    if (done == out.size()) grow(out, most);
    ZSTD_outBuffer room{out.data(), out.size(), done};
    const std::size_t before = in.pos, wants = ZSTD_decompressStream(stream.get(), &room, &in);
    if (ZSTD_isError(wants))
      throw std::runtime_error(std::string("zstd data is damaged: ") + ZSTD_getErrorName(wants));
    is_whole = wants == 0;
    if (!is_whole && done == room.pos && before == in.pos)
      throw std::runtime_error(
          done == most ? "zstd data unpacks to more than " + std::to_string(most) + " bytes"
                       : "zstd data is cut short");
    done = room.pos;
  }
  out.resize(done);
}
}  // namespace

bool is_zstd(std::string_view data) { return data.substr(0, 4) == "\x28\xb5\x2f\xfd"; }

void grow(std::vector<char>& out, std::size_t most)
{
  constexpr std::size_t kLeast = std::size_t{1} << 16;
  out.resize(std::min(most, std::max(2 * out.size(), kLeast)));
}

void unpack_bag_data(
    BagPacking packing, std::string_view packed, std::optional<std::size_t> size,
    std::vector<char>& out)
{
  if (size.value_or(0) > kMostBagBytes)
    throw std::runtime_error(
        "unpacks to " + std::to_string(*size) + " bytes, and no more than " +
        std::to_string(kMostBagBytes) + " are read at once");
  out.clear();
  if (packing == BagPacking::None)
    out.assign(packed.begin(), packed.end());
  else if (packing == BagPacking::Lz4)
    unpack_lz4(packed, size.value_or(kMostBagBytes), out);
  else
    unpack_zstd(packed, size, out);
  if (size && out.size() != *size)
    throw std::runtime_error(
        "unpacks to " + std::to_string(out.size()) + " bytes instead of " + std::to_string(*size));
}

}  // namespace talus::import
