#include <lz4frame.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <string>

#include "bag_unpack.h"

namespace talus::import
{
void unpack_lz4(std::string_view packed, std::size_t most, bool is_cut, std::vector<char>& out)
{
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, std::size_t (*)(LZ4F_dctx*)> stream(
      raw, LZ4F_freeDecompressionContext);
  std::size_t done = 0, at = 0;
  for (bool is_whole = false; !is_whole && done < most;)
  {
    if (done == out.size()) grow(out, most);
    std::size_t got = out.size() - done, took = packed.size() - at;
    const std::size_t wants =
        LZ4F_decompress(stream.get(), out.data() + done, &got, packed.data() + at, &took, nullptr);
    if (LZ4F_isError(wants) && is_cut) break;
    if (LZ4F_isError(wants))
      throw std::runtime_error(std::string("is damaged lz4 data: ") + LZ4F_getErrorName(wants));
    is_whole = wants == 0;
    const bool is_stuck = !is_whole && got == 0 && took == 0;
    if (is_stuck && is_cut) break;
    if (is_stuck) throw std::runtime_error("is lz4 data that is cut short");
    done += got;
    at += took;
  }
  out.resize(done);
}

}  // namespace talus::import
