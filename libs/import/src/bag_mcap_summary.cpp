#include "bag_mcap_summary.h"

#include <zlib.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace talus::import
{
namespace
{
McapSummary::Statistics statistics_of(RecordReader& record)
{
  McapSummary::Statistics statistics;
  statistics.messages = record.u64();
  record.u16();  // schemas
  record.u32();  // channels
  record.u32();  // attachments
  record.u32();  // metadata
  statistics.chunks = record.u32();
  record.u64();  // the first log_time
  record.u64();  // the last
  RecordReader counts(record.text());
  while (counts.left() > 0)
  {
    const auto channel = counts.u16();
    statistics.of_channel[channel] = counts.u64();
  }
  return statistics;
}

std::uint32_t crc_of(FileBytes& file, std::uint64_t begin, std::uint64_t end)
{
  constexpr std::uint64_t kPart = 1 << 16;
  auto crc = crc32(0, nullptr, 0);
  while (begin < end)
  {
    const auto part = file.look(begin, static_cast<std::size_t>(std::min(kPart, end - begin)));
    if (part.empty()) break;
    crc = crc32(crc, reinterpret_cast<const Bytef*>(part.data()), static_cast<uInt>(part.size()));
    begin += part.size();
  }
  return static_cast<std::uint32_t>(crc);
}
}  // namespace

void McapSummary::take(McapRecord op, std::uint64_t at, RecordReader record)
{
  if (op == McapRecord::Statistics) statistics = statistics_of(record);
  if (op == McapRecord::DataEnd)
  {
    data_end = at;
    data_crc = record.u32();
  }
  if (op == McapRecord::Footer)
  {
    footer = at;
    summary_begin = record.u64();
    record.u64();  // the offsets in it
    summary_crc = record.u32();
  }
}

void McapSummary::check(FileBytes& file) const
{
  if (data_crc != 0 && crc_of(file, 0, data_end) != data_crc)
    throw std::runtime_error(
        "the checksum of its data (DataEnd) does not agree: bytes before byte " +
        std::to_string(data_end) + " were changed");
  if (summary_crc == 0) return;
  const std::uint64_t begin = summary_begin == 0 ? footer : summary_begin;
  const std::uint64_t end = footer + kMcapRecordHead + 16;
  if (begin > footer || crc_of(file, begin, end) != summary_crc)
    throw std::runtime_error(
        "the checksum of its summary (Footer) does not agree: bytes from byte " +
        std::to_string(begin) + " on were changed");
}

}  // namespace talus::import
