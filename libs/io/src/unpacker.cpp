#include "unpacker.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>

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

/** Members one after the other; zlib compares checksum and length at the end of each. */
class Gz : public Unpacker
{
 public:
  Gz()
  {
    constexpr int kGzOnly = 16;
    if (inflateInit2(&stream_, MAX_WBITS + kGzOnly) != Z_OK) throw std::bad_alloc();
  }
  ~Gz() override { inflateEnd(&stream_); }

  const char* name() const override { return "gz"; }
  void unpack(Bytes& from, Room& to) override
  {
    if (is_between_ && from.size > 0)
    {
      inflateReset(&stream_);
      is_between_ = false;
    }
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(from.begin));
    stream_.avail_in = static_cast<uInt>(from.size);
    stream_.next_out = reinterpret_cast<Bytef*>(to.begin);
    stream_.avail_out = static_cast<uInt>(to.size);
    const int code = inflate(&stream_, Z_NO_FLUSH);
    advance(from, from.size - stream_.avail_in);
    advance(to, to.size - stream_.avail_out);
    if (code == Z_MEM_ERROR) throw std::bad_alloc();
    if (code == Z_STREAM_END)
      is_between_ = true;
    else if (code != Z_OK && code != Z_BUF_ERROR)  // the latter: nothing to do at the moment
      throw std::runtime_error(stream_.msg ? stream_.msg : "no gz data");
  }
  bool may_end() const override { return is_between_; }
  bool may_go_on_with(std::string_view begin) const override
  {
    return begins_with(begin, kGzBegin);
  }

 private:
  z_stream stream_{};
  bool is_between_ = false;  //!< two members
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

}  // namespace

std::unique_ptr<Unpacker> make_unpacker(std::string_view begin)
{
  if (begins_with(begin, kGzBegin)) return std::make_unique<Gz>();
  if (begins_with(begin, kZstdBegin)) return std::make_unique<Zstd>();
  return std::make_unique<NotPacked>();
}

}  // namespace talus::io
