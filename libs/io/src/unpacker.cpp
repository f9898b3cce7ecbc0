#include "packed_file.h"

#include <talus/io/packed_log.h>

#include <isa-l/igzip_lib.h>
#include <zstd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace talus::io
{
namespace
{
constexpr std::string_view kGzBegin = "\x1f\x8b", kZstdBegin = "\x28\xb5\x2f\xfd";

void advance(Bytes& from, std::size_t n) { from = {from.begin + n, from.size - n}; }
void advance(Room& to, std::size_t n) { to = {to.begin + n, to.size - n}; }

bool begins_with(std::string_view text, std::string_view begin)
{
  return text.substr(0, begin.size()) == begin;
}

class NotPacked : public Unpacker
{
 public:
  const char* name() const override { return ""; }
  void unpack(Bytes& from, Room& to) override
  {
    const std::size_t n = std::min(from.size, to.size);
    std::memcpy(to.begin, from.begin, n);
    advance(from, n);
    advance(to, n);
  }
  bool may_end() const override { return true; }
  bool may_go_on_with(std::string_view) const override { return true; }
};

const char* reason_of(int code)
{
  switch (code)
  {
    case ISAL_INCORRECT_CHECKSUM:
      return "its checksum is another";
    case ISAL_INVALID_WRAPPER:
    case ISAL_UNSUPPORTED_METHOD:
      return "no gz data";
    default:
      return "no data that was packed";
  }
}

/** Members one after the other; the library compares checksum and length at the end of each. */
class Gz : public Unpacker
{
 public:
  Gz() { isal_inflate_init(&state_), state_.crc_flag = ISAL_GZIP; }

  const char* name() const override { return "gz"; }
  void unpack(Bytes& from, Room& to) override
  {
    if (may_end() && from.size > 0) isal_inflate_reset(&state_);
    state_.next_in = reinterpret_cast<std::uint8_t*>(const_cast<char*>(from.begin));
    state_.avail_in = static_cast<std::uint32_t>(from.size);
    state_.next_out = reinterpret_cast<std::uint8_t*>(to.begin);
    state_.avail_out = static_cast<std::uint32_t>(to.size);
    const int code = isal_inflate(&state_);
    const bool is_past_end = state_.avail_in > from.size;  // damaged data may ask for more bits
    advance(from, is_past_end ? from.size : from.size - state_.avail_in);
    advance(to, to.size - state_.avail_out);
    if (code < 0) throw std::runtime_error(reason_of(code));
  }
  bool may_end() const override { return state_.block_state == ISAL_BLOCK_FINISH; }
  bool may_go_on_with(std::string_view begin) const override
  {
    return begins_with(begin, kGzBegin);
  }

 private:
  inflate_state state_;
};

/** Frames one after the other; the library compares the checksum where a frame has one. It refuses
 * frames that need a window of more than 128 MiB. */
class Zstd : public Unpacker
{
 public:
  Zstd() : stream_(ZSTD_createDStream(), ZSTD_freeDStream)
  {
    if (!stream_) throw std::bad_alloc();
  }

  const char* name() const override { return "zstd"; }
  void unpack(Bytes& from, Room& to) override
  {
    ZSTD_inBuffer in{from.begin, from.size, 0};
    ZSTD_outBuffer out{to.begin, to.size, 0};
    const std::size_t wants = ZSTD_decompressStream(stream_.get(), &out, &in);
    if (ZSTD_isError(wants)) throw std::runtime_error(ZSTD_getErrorName(wants));
    is_between_ = wants == 0;
    advance(from, in.pos);
    advance(to, out.pos);
  }
  bool may_end() const override { return is_between_; }
  bool may_go_on_with(std::string_view begin) const override
  {
    const bool is_skipped =  // a frame for other programs: 0x184D2A50 to 5F
        begins_with(begin.substr(1), "\x2a\x4d\x18") && (begin[0] & 0xf0) == 0x50;
    return begins_with(begin, kZstdBegin) || is_skipped;
  }

 private:
  std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream_;
  bool is_between_ = false;  //!< two frames
};

template <class T>
std::unique_ptr<Unpacker> make()
{
  return std::make_unique<T>();
}

struct Packing
{
  std::string_view begin;  //!< of its files
  std::vector<std::string_view> endings;
  std::unique_ptr<Unpacker> (*make)();
};
const std::vector<Packing> kPackings = {
    {kGzBegin, {".gz"}, make<Gz>}, {kZstdBegin, {".zst", ".zstd"}, make<Zstd>}};
}  // namespace

std::unique_ptr<Unpacker> make_unpacker(std::string_view begin)
{
  for (const Packing& packing : kPackings)
    if (begins_with(begin, packing.begin)) return packing.make();
  return std::make_unique<NotPacked>();
}

std::string without_packing(const std::string& name)
{
  for (const Packing& packing : kPackings)
    for (const std::string_view ending : packing.endings)
    {
      const std::size_t end = name.size() - std::min(name.size(), ending.size());
      if (end > 0 && name[end - 1] != '/' && name.substr(end) == ending) return name.substr(0, end);
    }
  return name;
}

}  // namespace talus::io
