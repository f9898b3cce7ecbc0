#pragma once
#include <cstdint>
#include <map>
#include <optional>

#include "bag_bytes.h"

namespace talus::import
{
/** Opcodes of the records of MCAP, https://mcap.dev/spec. */
enum class McapRecord : std::uint8_t
{
  None = 0x00,
  Header = 0x01,
  Footer = 0x02,
  Schema = 0x03,
  Channel = 0x04,
  Message = 0x05,
  Chunk = 0x06,
  Statistics = 0x0B,
  DataEnd = 0x0F
};

constexpr std::uint64_t kMcapRecordHead = 9;  //!< bytes of opcode and length

/** What the end of an MCAP file tells of the rest. */
struct McapSummary
{
  struct Statistics
  {
    std::uint64_t messages = 0;
    std::uint32_t chunks = 0;
    std::map<std::uint16_t, std::uint64_t> of_channel;  //!< messages; empty: not told
  };
  std::optional<Statistics> statistics;
  std::uint64_t data_end = 0;  //!< the byte of DataEnd
  std::uint32_t data_crc = 0;  //!< of all before; 0: not told
  std::uint64_t footer = 0;  //!< the byte of Footer
  std::uint64_t summary_begin = 0;
  std::uint32_t summary_crc = 0;  //!< from summary_begin up to itself; 0: not told

  /** Statistics, DataEnd or Footer at byte `at`; others are nothing to it. Throws
   * std::runtime_error "is cut short". */
  void take(McapRecord op, std::uint64_t at, RecordReader record);

  /** Throws std::runtime_error, with what is wrong only, where a checksum does not agree. */
  void check(FileBytes& file) const;
};

}  // namespace talus::import
