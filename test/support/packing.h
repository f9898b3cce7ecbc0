#pragma once
// Bytes packed as programs of MRPT pack their files.
#include <zlib.h>
#include <zstd.h>

#include <stdexcept>
#include <string>

namespace talus::test
{
/** One member. */
inline std::string gz_of(const std::string& bytes)
{
  z_stream stream{};
  constexpr int kGz = 16;
  deflateInit2(&stream, 6, Z_DEFLATED, MAX_WBITS + kGz, 8, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&stream, bytes.size()) + 32, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) throw std::logic_error("room is too small");
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/** One frame, with a checksum unless told otherwise. */
inline std::string zstd_of(const std::string& bytes, bool with_checksum = true)
{
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, with_checksum);
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const auto size =
      ZSTD_compress2(context, packed.data(), packed.size(), bytes.data(), bytes.size());
  ZSTD_freeCCtx(context);
  if (ZSTD_isError(size)) throw std::logic_error(ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}

}  // namespace talus::test
