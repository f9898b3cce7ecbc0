#include <cdr_writer.h>
#include <talus/formats/write.h>
#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include "needed_layer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string_view>

namespace talus::formats
{
namespace
{
constexpr std::size_t kMaxBytes = 100'000'000;  //!< of a message: readers of bags have limits
constexpr const char* kTopic = "/grid_map";  // as grid_map_loader has it
constexpr const char* kType = "grid_map_msgs/msg/GridMap";
constexpr const char* kDefinition =
    "std_msgs/Header header\ngrid_map_msgs/GridMapInfo info\nstring[] layers\n"
    "string[] basic_layers\nstd_msgs/Float32MultiArray[] data\nuint16 outer_start_index\n"
    "uint16 inner_start_index\n";
/** A type that the definition uses, and its fields. */
constexpr const char* kParts[][2] = {
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"grid_map_msgs/GridMapInfo",
     "float64 resolution\nfloat64 length_x\nfloat64 length_y\ngeometry_msgs/Pose pose\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"std_msgs/Float32MultiArray", "std_msgs/MultiArrayLayout layout\nfloat32[] data\n"},
    {"std_msgs/MultiArrayLayout", "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n"},
    {"std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride\n"}};

std::int64_t nanoseconds(double stamp_s)
{
  return static_cast<std::int64_t>(std::llround(stamp_s * 1e7)) * 100;  // as in logs
}

/** Bytes of a file of MCAP; its numbers are little-endian, as is every machine that MRPT runs on.
 */
class Mcap
{
 public:
  template <class T>
  Mcap& put(T value)
  {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  /** With its length before it. */
  Mcap& text(std::string_view text)
  {
    put(static_cast<std::uint32_t>(text.size()));
    bytes += text;
    return *this;
  }
  /** With its kind and length. */
  Mcap& record(std::uint8_t kind, std::string_view content)
  {
    put(kind).put(std::uint64_t{content.size()});
    bytes += content;
    return *this;
  }
  std::string bytes;
};

enum Record : std::uint8_t
{
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 11,
  kDataEnd = 15
};

std::string schema_and_channel()
{
  std::string definition = kDefinition;
  for (const auto& [name, fields] : kParts)
    definition += std::string(80, '=') + "\nMSG: " + name + "\n" + fields;
  const auto schema =
      Mcap().put(std::uint16_t{1}).text(kType).text("ros2msg").text(definition).bytes;
  const auto channel = Mcap()
                           .put(std::uint16_t{1})
                           .put(std::uint16_t{1})
                           .text(kTopic)
                           .text("cdr")
                           .put(std::uint32_t{0})
                           .bytes;
  return Mcap().record(kSchema, schema).record(kChannel, channel).bytes;
}

/** What a reader looks up: where the chunk and its message are. */
std::string summary(
    std::uint64_t time_ns, std::uint64_t chunk_at, std::uint64_t chunk_bytes,
    std::uint64_t index_bytes, std::uint64_t unpacked_bytes)
{
  const auto index = Mcap()
                         .put(time_ns)
                         .put(time_ns)
                         .put(chunk_at)
                         .put(chunk_bytes)
                         .put(std::uint32_t{10})
                         .put(std::uint16_t{1})
                         .put(chunk_at + chunk_bytes)
                         .put(index_bytes)
                         .text("")
                         .put(unpacked_bytes)
                         .put(unpacked_bytes)
                         .bytes;
  Mcap statistics;
  statistics.put(std::uint64_t{1}).put(std::uint16_t{1}).put(std::uint32_t{1});
  statistics.put(std::uint32_t{0}).put(std::uint32_t{0}).put(std::uint32_t{1});
  statistics.put(time_ns).put(time_ns);
  statistics.put(std::uint32_t{10}).put(std::uint16_t{1}).put(std::uint64_t{1});
  return schema_and_channel() +
         Mcap().record(kStatistics, statistics.bytes).record(kChunkIndex, index).bytes;
}

/** A bag of one message. */
void write_bag(const std::string& path, const std::string& message, std::uint64_t time_ns)
{
  constexpr std::string_view kMagic = "\x89MCAP0\r\n";
  constexpr std::size_t kHead = 1 + sizeof(std::uint64_t);  // of a record
  std::string before = schema_and_channel();
  const std::size_t offset = before.size();
  Mcap of_message;
  of_message.put(std::uint16_t{1}).put(std::uint32_t{0}).put(time_ns).put(time_ns);
  before += Mcap().put(kMessage).put(std::uint64_t{of_message.bytes.size() + message.size()}).bytes;
  before += of_message.bytes;
  const std::uint64_t unpacked = before.size() + message.size();
  Mcap chunk;  // up to its records
  chunk.put(time_ns).put(time_ns).put(unpacked).put(std::uint32_t{0}).text("").put(unpacked);
  const std::uint64_t chunk_bytes = kHead + chunk.bytes.size() + unpacked;

  Mcap file;
  file.bytes = kMagic;
  file.record(kHeader, Mcap().text("ros2").text("talus").bytes);
  const std::uint64_t chunk_at = file.bytes.size();
  file.put(kChunk).put(chunk_bytes - kHead);
  file.bytes += chunk.bytes + before;

  Mcap end;
  end.record(
      kMessageIndex, Mcap()
                         .put(std::uint16_t{1})
                         .put(std::uint32_t{16})
                         .put(time_ns)
                         .put(std::uint64_t{offset})
                         .bytes);
  const std::uint64_t index_bytes = end.bytes.size();
  end.record(kDataEnd, Mcap().put(std::uint32_t{0}).bytes);
  const std::uint64_t summary_at = file.bytes.size() + message.size() + end.bytes.size();
  end.bytes += summary(time_ns, chunk_at, chunk_bytes, index_bytes, unpacked);
  end.record(kFooter, Mcap().put(summary_at).put(std::uint64_t{0}).put(std::uint32_t{0}).bytes);
  end.bytes += kMagic;

  io::AtomicFile to(path);
  for (const std::string_view bytes :
       {std::string_view(file.bytes), std::string_view(message), std::string_view(end.bytes)})
    to.write(bytes);
  to.commit();
}
}  // namespace

std::string grid_map_message(
    double stamp_s, const std::string& frame, const io::LayerStack& map,
    const std::vector<std::string>& layers)
{
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  const auto columns = static_cast<std::uint32_t>(map.cells_y),
             rows = static_cast<std::uint32_t>(map.cells_x);
  const double length_x_m = map.cells_x * map.resolution_m,
               length_y_m = map.cells_y * map.resolution_m;
  io::CdrWriter out;
  out.put(static_cast<std::int32_t>(nanoseconds(stamp_s) / kSecond_ns));
  out.put(static_cast<std::uint32_t>(nanoseconds(stamp_s) % kSecond_ns));
  out.text(frame);
  for (const double number :
       {map.resolution_m, length_x_m, length_y_m, map.min_x_m + length_x_m / 2,
        map.min_y_m + length_y_m / 2, 0.0, 0.0, 0.0, 0.0, 1.0})
    out.put(number);
  out.put(static_cast<std::uint32_t>(layers.size()));
  for (const auto& name : layers) out.text(name);
  out.put(std::uint32_t{0});  // basic layers
  out.put(static_cast<std::uint32_t>(layers.size()));
  for (const auto& name : layers)
  {
    const auto* from = map.find(name);
    if (!from) throw std::runtime_error("the map has no layer '" + name + "'");
    // Its rows begin at the far end of x, its columns at that of y, and columns follow each other:
    // all cells from the last one on.
    const std::vector<float> turned(from->rbegin(), from->rend());
    out.put(std::uint32_t{2});
    out.text("column_index");
    out.put(columns);
    out.put(rows * columns);
    out.text("row_index");
    out.put(rows);
    out.put(rows);
    out.put(std::uint32_t{0});
    out.sequence(turned.data(), turned.size());
  }
  out.put(std::uint16_t{0});
  out.put(std::uint16_t{0});
  return out.bytes();
}

std::string write_grid_map(const std::string& path, const MapStrips& map, double stamp_s)
{
  const auto fits = [](const MapStrips& m)
  {
    const io::LayerStack& f = m.frame();
    return std::size_t{4} * f.names.size() * f.cells_x * f.cells_y <= kMaxBytes;
  };
  const MapStrips shown = joined_until(fits, map);
  const io::LayerStack whole = shown.whole();
  write_bag(
      path, grid_map_message(stamp_s, "map", whole, whole.names),
      static_cast<std::uint64_t>(std::max<std::int64_t>(0, nanoseconds(stamp_s))));
  if (whole.resolution_m == map.frame().resolution_m) return "";
  return path + ": its cells are " + number_text(whole.resolution_m) + " m wide, not " +
         number_text(map.frame().resolution_m) + " m: a message has no more than 100 MB";
}

}  // namespace talus::formats
