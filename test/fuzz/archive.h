#pragma once
// Objects of MRPT out of bytes and into bytes.
#include <talus/mrpt/CDualElevationMap.h>

#include "../support/streams.h"

namespace talus::fuzz
{
template <class T>
void read_object(const std::uint8_t* data, std::size_t size, T& object)
{
  static const bool known =
      (register_mrpt_classes(), mrpt::rtti::registerAllPendingClasses(), true);
  (void)known;
  talus_test::read({data, data + size}, object);
}

/** What was written of an object that was read gives the same bytes again. */
template <class T>
bool keeps_its_bytes(const T& object)
{
  const auto bytes = talus_test::bytes_of(object);
  return talus_test::bytes_of(talus_test::read<T>(bytes)) == bytes;
}

}  // namespace talus::fuzz
