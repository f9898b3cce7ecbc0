#pragma once
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include <cstddef>
#include <string>

namespace talus::live
{
/** A message of Cyclone DDS whose bytes nobody looks at. */
struct RawMessage : ddsi_serdata
{
  std::string bytes;  //!< with encapsulation, and zeros up to a multiple of 4
};

/** Messages of more bytes are dropped. */
constexpr std::size_t kMaxMessage_bytes = std::size_t{1} << 26;

/** The type of such messages, by its name in DDS. For dds_create_topic_sertype(). */
ddsi_sertype* make_raw_type(const std::string& name);

/** A message of this type, for dds_writecdr(). */
RawMessage* make_raw_message(const ddsi_sertype* type, std::string bytes);

}  // namespace talus::live
