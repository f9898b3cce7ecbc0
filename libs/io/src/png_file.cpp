#include "png_file.h"

#include <isa-l/crc.h>
#include <isa-l/igzip_lib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

// OpenCV packs pictures with zlib, which takes four times as long.
namespace talus::io
{
namespace
{
void put_word(std::string& to, std::uint32_t word)
{
  for (int shift = 24; shift >= 0; shift -= 8) to += static_cast<char>(word >> shift);
}

void put_chunk(std::string& to, const char* type, const std::string& data)
{
  put_word(to, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = to.size();
  to += type + data;
  const auto* const from = reinterpret_cast<const unsigned char*>(to.data()) + begin;
  put_word(to, crc32_gzip_refl(0, from, to.size() - begin));
}

std::string header_of(const cv::Mat& picture)
{
  constexpr char kGrey = 0, kInColour = 2, kWithAlpha = 6;
  std::string header;
  put_word(header, static_cast<std::uint32_t>(picture.cols));
  put_word(header, static_cast<std::uint32_t>(picture.rows));
  header += static_cast<char>(8 * picture.elemSize1());
  header += picture.channels() == 4 ? kWithAlpha : picture.channels() == 3 ? kInColour : kGrey;
  return header + std::string(3, '\0');  // deflate, its filters, not interlaced
}

/** Red first, and the higher of two bytes. */
std::vector<std::uint8_t> row_of(const cv::Mat& picture, int y)
{
  const std::size_t size = static_cast<std::size_t>(picture.cols) * picture.elemSize();
  const std::uint8_t* const from = picture.ptr(y);
  std::vector<std::uint8_t> row(from, from + size);
  const std::size_t pixel = picture.elemSize(), other = pixel > 2 ? 2 : 1;
  for (std::size_t i = 0; pixel > 1 && i < size; i += pixel) std::swap(row[i], row[i + other]);
  return row;
}

/** As what it is more than the pixel to its left. */
void filter(const std::vector<std::uint8_t>& row, std::size_t pixel, std::vector<std::uint8_t>& to)
{
  constexpr std::uint8_t kLessLeft = 1;
  to.resize(row.size() + 1);
  to[0] = kLessLeft;
  std::copy_n(row.begin(), pixel, to.begin() + 1);
  for (std::size_t i = pixel; i < row.size(); ++i)
    to[i + 1] = static_cast<std::uint8_t>(row[i] - row[i - pixel]);
}

/** Of level 2: 1 % larger than zlib's level 1. */
std::string packed_rows(const cv::Mat& picture)
{
  std::vector<std::uint8_t> work(ISAL_DEF_LVL2_DEFAULT), row, part(std::size_t{1} << 16);
  isal_zstream stream;
  isal_deflate_init(&stream);
  stream.gzip_flag = IGZIP_ZLIB;
  stream.level = 2;
  stream.level_buf = work.data();
  stream.level_buf_size = static_cast<std::uint32_t>(work.size());
  std::string packed;
  for (int y = 0; y < picture.rows; ++y)
  {
    filter(row_of(picture, y), picture.elemSize(), row);
    stream.next_in = row.data();
    stream.avail_in = static_cast<std::uint32_t>(row.size());
    stream.end_of_stream = y + 1 == picture.rows ? 1 : 0;
    do
    {
      stream.next_out = part.data();
      stream.avail_out = static_cast<std::uint32_t>(part.size());
      isal_deflate(&stream);
      packed.append(reinterpret_cast<const char*>(part.data()), part.size() - stream.avail_out);
    } while (stream.avail_out == 0);
  }
  return packed;
}
}  // namespace

std::string png_of(const cv::Mat& picture)
{
  const int type = picture.type();
  if (picture.empty() ||
      (type != CV_8UC4 && type != CV_8UC3 && type != CV_8UC1 && type != CV_16UC1))
    return "";
  std::string png = "\x89PNG\r\n\x1a\n";
  put_chunk(png, "IHDR", header_of(picture));
  put_chunk(png, "IDAT", packed_rows(picture));
  put_chunk(png, "IEND", "");
  return png;
}

}  // namespace talus::io
