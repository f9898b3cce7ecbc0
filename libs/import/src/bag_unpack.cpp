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

void unpack_zstd(std::string_view packed, std::size_t most, bool is_cut, std::vector<char>& out)
{
  const Stream stream(ZSTD_createDStream(), ZSTD_freeDStream);
  if (!stream) throw std::bad_alloc();
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  std::size_t done = 0;
  for (bool is_whole = false; !is_whole && done < most;)
  {
    if (done == out.size()) grow(out, most);
    ZSTD_outBuffer room{out.data(), out.size(), done};
    const std::size_t before = in.pos, wants = ZSTD_decompressStream(stream.get(), &room, &in);
    if (ZSTD_isError(wants) && is_cut) break;
    if (ZSTD_isError(wants))
      throw std::runtime_error(std::string("is damaged zstd data: ") + ZSTD_getErrorName(wants));
    is_whole = wants == 0;
    const bool is_stuck = !is_whole && done == room.pos && before == in.pos;
    done = room.pos;
    if (is_stuck && is_cut) break;
    if (is_stuck) throw std::runtime_error("is zstd data that is cut short");
  }
  out.resize(done);
}
}  // namespace

bool is_zstd(std::string_view data) { return data.substr(0, 4) == "\x28\xb5\x2f\xfd"; }

void grow(std::vector<char>& out, std::size_t most)
{
  constexpr std::size_t kMin = std::size_t{1} << 16;
  out.resize(std::min(most, std::max(2 * out.size(), kMin)));
}

std::size_t most_unpacked(std::uint64_t packed_bytes)
{
  constexpr std::uint64_t kFew = std::uint64_t{1} << 24, kMaxTimes = 64;
  return std::min<std::uint64_t>(kMaxBagBytes, std::max(kFew, kMaxTimes * packed_bytes));
}

void unpack_bag_data(
    BagPacking packing, std::string_view packed, const UnpackedSize& size, std::vector<char>& out)
{
  const auto too_much = [&](std::size_t bytes)
  {
    return std::runtime_error(
        "unpacks to " + std::to_string(bytes) + " bytes or more, and from " +
        std::to_string(packed.size()) + " packed bytes no more than " + std::to_string(size.most) +
        " are taken");
  };
  if (size.expected.value_or(0) > size.most) throw too_much(*size.expected);
  // One more than may come out shows that there is more.
  const std::size_t most = size.expected.value_or(size.most + 1);
  out.clear();
  if (packing == BagPacking::None)
    out.assign(packed.begin(), packed.end());
  else if (packing == BagPacking::Lz4)
    unpack_lz4(packed, most, size.is_cut, out);
  else
    unpack_zstd(packed, most, size.is_cut, out);
  if (!size.expected && out.size() > size.most) throw too_much(out.size());
  if (size.expected && !size.is_cut && out.size() != *size.expected)
    throw std::runtime_error(
        "unpacks to " + std::to_string(out.size()) + " bytes instead of " +
        std::to_string(*size.expected));
}

}  // namespace talus::import
