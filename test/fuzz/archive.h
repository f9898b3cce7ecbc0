#pragma once
// Objects of MRPT out of bytes and into bytes.
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <cstdint>
#include <string>

namespace talus::fuzz
{
template <class T>
void read_object(const void* data, std::size_t size, T& object)
{
  static const bool known =
      (register_mrpt_classes(), mrpt::rtti::registerAllPendingClasses(), true);
  (void)known;
  mrpt::io::CMemoryStream stream(data, size);
  auto in = mrpt::serialization::archiveFrom(stream);
  in >> object;
}

template <class T>
std::string bytes_of_object(const T& object)
{
  mrpt::io::CMemoryStream stream;
  auto out = mrpt::serialization::archiveFrom(stream);
  out << object;
  return {
      static_cast<const char*>(stream.getRawBufferData()),
      static_cast<std::size_t>(stream.getTotalBytesCount())};
}

/** What was written of an object that was read gives the same bytes again. */
template <class T>
bool keeps_its_bytes(const T& object)
{
  const std::string bytes = bytes_of_object(object);
  T again;
  read_object(bytes.data(), bytes.size(), again);
  return bytes_of_object(again) == bytes;
}

}  // namespace talus::fuzz
