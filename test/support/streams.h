#pragma once
// Objects of MRPT as bytes, and back.
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <string>
#include <vector>

namespace talus_test
{
using Bytes = std::vector<std::uint8_t>;

/** What a function writes into an archive. */
template <class Write>
Bytes written_by(const Write& write)
{
  mrpt::io::CMemoryStream stream;
  auto out = mrpt::serialization::archiveFrom(stream);
  write(out);
  const auto* begin = static_cast<const std::uint8_t*>(stream.getRawBufferData());
  return {begin, begin + stream.getTotalBytesCount()};
}

template <class T>
Bytes bytes_of(const T& object)
{
  return written_by([&](auto& out) { out << object; });
}

/** One object as MRPT frames it: length of the name, name, version, content, end. */
template <class Write>
Bytes framed(const std::string& name, std::uint8_t version, const Write& content)
{
  return written_by(
      [&](auto& out)
      {
        out << static_cast<std::uint8_t>(name.size() | 0x80);
        out.WriteBuffer(name.data(), name.size());
        out << version;
        content(out);
        out << std::uint8_t(0x88);
      });
}

/** Throws what reading throws. */
template <class T>
void read(const Bytes& bytes, T& object)
{
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data(), bytes.size());
  auto in = mrpt::serialization::archiveFrom(stream);
  in >> object;
}

template <class T>
T read(const Bytes& bytes)
{
  T object;
  read(bytes, object);
  return object;
}

}  // namespace talus_test
