#include "bag_messages.h"

#include <talus/text.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "cdr_reader.h"

namespace talus::import
{
namespace
{
/** Frames of ROS 1 began with a slash. */
std::string frame_name(std::string name)
{
  constexpr std::size_t kLongest = 256;
  if (name.size() > kLongest)
    throw CdrError(
        "names a frame with " + std::to_string(name.size()) + " letters: '" + name.substr(0, 24) +
        "...'");
  if (!name.empty() && name[0] == '/') name.erase(0, 1);
  return name;
}

MessageHeader header_of(CdrReader& in)
{
  constexpr std::int64_t kSecond_ns = 1000000000;
  MessageHeader header;
  const std::int64_t seconds = in.i32();
  header.stamp_ns = seconds * kSecond_ns + in.u32();
  header.frame = frame_name(in.string());
  return header;
}

std::optional<mrpt::math::TPose3DQuat> pose_of(CdrReader& in)
{
  constexpr double kFarthest_m = 1e9, kMinNorm = 0.9, kMaxNorm = 1.1;
  std::array<double, 7> v{};  // x y z, qx qy qz qw
  for (double& number : v) number = in.f64();
  const double norm = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
  bool is_good = norm >= kMinNorm && norm <= kMaxNorm;
  for (std::size_t i = 0; i < 3; ++i) is_good = is_good && std::abs(v[i]) <= kFarthest_m;
  if (!is_good) return std::nullopt;
  return mrpt::math::TPose3DQuat(
      v[0], v[1], v[2], v[6] / norm, v[3] / norm, v[4] / norm, v[5] / norm);
}

FrameTransform transform_of(CdrReader& in)
{
  FrameTransform transform;
  transform.parent = header_of(in);
  transform.child = frame_name(in.string());
  transform.T_parent_child = pose_of(in);
  return transform;
}

FrameTransform stamped_pose_of(CdrReader& in)
{
  FrameTransform transform;
  transform.parent = header_of(in);
  transform.T_parent_child = pose_of(in);
  return transform;
}

/** CustomMsg of Livox's drivers: each point is uint32 offset_time [ns since timebase], float32 x, y
 * and z, uint8 reflectivity, tag and line. */
CloudMessage read_livox(std::string_view message)
{
  constexpr std::uint32_t kPoint_bytes = 19, kStep_bytes = 20;
  constexpr std::uint64_t kMaxStamp_ns = std::numeric_limits<std::int64_t>::max();
  CdrReader in(message);
  CloudMessage cloud;
  cloud.header = header_of(in);
  const std::uint64_t timebase_ns = in.u64();
  if (cloud.header.stamp_ns == 0)
    cloud.header.stamp_ns = static_cast<std::int64_t>(timebase_ns & kMaxStamp_ns);
  in.u32();  // number of points, once more
  for (int i = 0; i < 4; ++i) in.u8();  // number of the scanner; reserved
  cloud.height = 1;
  cloud.width = in.count(kPoint_bytes);
  cloud.fields = {{{"offset_time", NumberType::UInt32}, 0},  {{"x", NumberType::Float32}, 4},
                  {{"y", NumberType::Float32}, 8},           {{"z", NumberType::Float32}, 12},
                  {{"reflectivity", NumberType::UInt8}, 16}, {{"tag", NumberType::UInt8}, 17},
                  {{"line", NumberType::UInt8}, 18}};
  cloud.point_step = kStep_bytes;
  cloud.is_big_endian = message[1] == 0;
  cloud.data = in.rest();
  return cloud;
}

/** By the numbers of sensor_msgs/msg/PointField. */
NumberType type_of(std::uint8_t number, const std::string& field)
{
  constexpr std::uint8_t kTruth = 11;
  if (number < 1 || number > kTruth)
    throw CdrError(
        "has a field '" + field.substr(0, 24) + "' of type " + std::to_string(number) +
        ", which is not known");
  return number == kTruth ? NumberType::UInt8 : static_cast<NumberType>(number - 1);
}

CloudMessage::Field field_of(CdrReader& in)
{
  CloudMessage::Field field;
  field.name = in.string();
  field.offset = in.u32();
  field.type = type_of(in.u8(), field.name);
  const std::uint32_t count = in.u32();
  field.count = count == 0 ? 1 : count;  // writers in Python leave it 0, and PCL takes that for 1
  return field;
}

/** Bytes from one row to the next. Drivers fill it in where there are several. */
std::uint64_t row_step_of(const CloudMessage& cloud)
{
  const std::uint64_t least = std::uint64_t{cloud.width} * cloud.point_step;
  return cloud.height <= 1 || cloud.row_step == 0 ? least : cloud.row_step;
}

void require_sizes(const CloudMessage& cloud)
{
  constexpr std::uint64_t kMaxPoints = std::uint64_t{1} << 24;
  const std::uint64_t points = std::uint64_t{cloud.width} * cloud.height;
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step,
                      step = row_step_of(cloud);
  const std::string size = std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
                           " points of " + std::to_string(cloud.point_step) + " bytes";
  if (points > kMaxPoints) throw CdrError("says it has " + size + ", more than any scan has");
  std::uint64_t point = 0;  // of the last one: what is behind its fields may be missing
  for (const auto& f : cloud.fields)
    point = std::max(point, f.offset + std::uint64_t{f.count} * bytes_of(f.type));
  const std::uint64_t missing = cloud.point_step - std::min<std::uint64_t>(point, cloud.point_step);
  if (step < row || row + (cloud.height - 1) * step > cloud.data.size() + missing)
    throw CdrError(
        "says it has " + size + " in rows of " + std::to_string(step) + ", but has " +
        std::to_string(cloud.data.size()) + " bytes of them");
}
/** Each of the fields has bytes of its own in a point. */
void require_places(const CloudMessage& cloud, const std::vector<std::size_t>& wanted)
{
  const auto end_of = [](const CloudMessage::Field& f)
  { return std::uint64_t{f.offset} + bytes_of(f.type); };
  for (const auto i : wanted)
  {
    const auto& field = cloud.fields[i];
    const std::string name = "'" + field.name.substr(0, 24) + "'";
    if (end_of(field) > cloud.point_step)
      throw CdrError("has a field " + name + " outside of its points");
    for (const auto k : wanted)
      if (const auto& other = cloud.fields[k];
          k != i && other.offset < end_of(field) && field.offset < end_of(other))
        throw CdrError(
            "has a field " + name + " in the same bytes as '" + other.name.substr(0, 24) + "'");
  }
}
}  // namespace

MessageHeader read_header(std::string_view message)
{
  CdrReader in(message);
  return header_of(in);
}

void for_each_link(std::string_view message, const std::function<void(FrameTransform)>& take)
{
  constexpr std::size_t kMinBytes = 64;  // numbers alone
  CdrReader in(message);
  for (auto left = in.count(kMinBytes); left > 0; --left) take(transform_of(in));
}

FrameTransform read_odometry(std::string_view message)
{
  CdrReader in(message);
  return transform_of(in);
}

FrameTransform read_pose(std::string_view message)
{
  CdrReader in(message);
  return stamped_pose_of(in);
}

void for_each_pose(std::string_view message, const std::function<void(FrameTransform)>& take)
{
  constexpr std::size_t kMinBytes = 64;
  CdrReader in(message);
  header_of(in);
  for (auto left = in.count(kMinBytes); left > 0; --left) take(stamped_pose_of(in));
}

CloudMessage read_cloud(std::string_view message, const std::string& type)
{
  if (ends_with(type, "/CustomMsg")) return read_livox(message);
  constexpr std::size_t kMinFieldBytes = 12, kMaxFields = 1000;
  CdrReader in(message);
  CloudMessage cloud;
  cloud.header = header_of(in);
  cloud.height = in.u32();
  cloud.width = in.u32();
  const auto count = in.count(kMinFieldBytes);
  if (count > kMaxFields)
    throw CdrError("says its points have " + std::to_string(count) + " fields");
  cloud.fields.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) cloud.fields.push_back(field_of(in));
  cloud.is_big_endian = in.flag();
  cloud.point_step = in.u32();
  cloud.row_step = in.u32();
  cloud.data = in.bytes();
  return cloud;
}

bool is_of_other_order(
    const CloudMessage& cloud, const std::string& place, std::uint64_t most_points)
{
  const auto sane_points = [&](bool is_big_endian)
  {
    constexpr double kNearest_m = 1e-3, kFarthest_m = 1e4;
    CloudMessage read_so = cloud;
    read_so.is_big_endian = is_big_endian;
    ScanFile points;
    collect_points(read_so, place, points, most_points);
    std::size_t sane = 0;
    for (std::size_t i = 0; i < points.x_m.size(); ++i)
    {
      const double far_m =
          std::max({std::abs(points.x_m[i]), std::abs(points.y_m[i]), std::abs(points.z_m[i])});
      sane += far_m >= kNearest_m && far_m <= kFarthest_m ? 1 : 0;
    }
    return sane;
  };
  constexpr std::size_t kTimesMore = 5;
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  const auto other = sane_points(!cloud.is_big_endian);
  return 2 * other > points && other > kTimesMore * sane_points(cloud.is_big_endian);
}

void collect_points(
    const CloudMessage& cloud, const std::string& place, ScanFile& out, std::uint64_t most_points)
{
  out.clear();
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  if (points == 0) return;
  require_sizes(cloud);
  PointCollector collector({cloud.fields.begin(), cloud.fields.end()}, points, place, out);
  require_places(cloud, collector.wanted());
  std::vector<FieldPosition> places(cloud.fields.size());
  for (std::size_t row = 0; row < cloud.height; ++row)
  {
    const char* const data = cloud.data.data() + row * row_step_of(cloud);
    for (std::size_t i = 0; i < places.size(); ++i)
      places[i] = {data + cloud.fields[i].offset, cloud.point_step, cloud.is_big_endian};
    if (!collector.add_records(places, cloud.width, most_points))
      throw CdrError(
          "unpacks to more than " + std::to_string(most_points) +
          " points, and the bytes of it in the file hold no more");
  }
  collector.finish();
}

}  // namespace talus::import
