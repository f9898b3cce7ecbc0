#include "stream_reader.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace talus::detail
{
namespace
{
constexpr std::uint64_t kPiece = 1 << 20;  // what is allocated before its bytes have arrived
}

StreamReader::StreamReader(mrpt::serialization::CArchive& in, std::string object)
    : in_(in), object_(std::move(object))
{
}

void StreamReader::fail(const std::string& what) const
{
  throw std::runtime_error(
      object_ + ": the stream is damaged (" + what + "); take another copy of it or write it anew");
}

bool StreamReader::flag(const char* what)
{
  const auto value = number<std::uint8_t>(what);
  if (value > 1) fail(what);
  return value == 1;
}

std::string StreamReader::text(std::size_t longest, const char* what)
{
  const auto size = number<std::uint32_t>(what);
  if (size > longest) fail(what);
  const auto read = bytes(size, what);
  return {read.begin(), read.end()};
}

std::vector<std::uint8_t> StreamReader::bytes(std::uint64_t size, const char* what)
{
  std::vector<std::uint8_t> read;
  while (read.size() < size)
  {
    const auto begin = read.size();
    const auto piece = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, size - begin));
    read.resize(begin + piece);
    if (in_.ReadBuffer(read.data() + begin, piece) != piece) fail(what);
  }
  return read;
}

mrpt::poses::CPose3D StreamReader::pose(const char* what)
{
  mrpt::poses::CPose3D p;
  in_ >> p;
  if (!std::isfinite(p.x() + p.y() + p.z() + p.yaw() + p.pitch() + p.roll())) fail(what);
  return p;
}
}  // namespace talus::detail
