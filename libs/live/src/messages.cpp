#include <mrpt/poses/CPose3DQuat.h>
#include <cdr_writer.h>
#include <talus/live/messages.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

using mrpt::poses::CPose3D;

namespace talus::live
{
namespace
{
using io::CdrWriter;

void put_time(CdrWriter& out, double stamp_s)
{
  constexpr std::int64_t kSecond_ns = 1000000000;
  const auto stamp_ns = static_cast<std::int64_t>(std::llround(stamp_s * 1e7)) * 100;  // as in logs
  out.put(static_cast<std::int32_t>(stamp_ns / kSecond_ns));
  out.put(static_cast<std::uint32_t>(stamp_ns % kSecond_ns));
}

void put_header(CdrWriter& out, const Header& header)
{
  put_time(out, header.stamp_s);
  out.text(header.frame);
}

/** Both geometry_msgs/Pose and Transform. */
void put_pose(CdrWriter& out, const CPose3D& pose)
{
  const mrpt::poses::CPose3DQuat p(pose);
  const auto& q = p.quat();
  for (const double number : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.r()}) out.put(number);
}

void put_link(CdrWriter& out, const Link& link)
{
  put_header(out, link.header);
  out.text(link.child);
  put_pose(out, link.T_parent_child);
}

/** A field of floats of sensor_msgs/PointCloud2. */
struct Field
{
  const char* name;
  const std::vector<float>* values;
};
}  // namespace

std::string tf_message(const std::vector<Link>& links)
{
  CdrWriter out;
  out.put(static_cast<std::uint32_t>(links.size()));
  for (const auto& link : links) put_link(out, link);
  return out.bytes();
}

std::string odometry_message(const Link& pose)
{
  constexpr std::size_t kCovariance = 36, kVelocities = 6;
  const std::array<double, 2 * kCovariance + kVelocities> none{};
  CdrWriter out;
  put_link(out, pose);
  out.array(none.data(), none.size());
  return out.bytes();
}

std::string cloud_message(const Header& header, const CloudPoints& points)
{
  constexpr std::uint8_t kFloat32 = 7;
  std::vector<Field> fields = {{"x", &points.x_m}, {"y", &points.y_m}, {"z", &points.z_m}};
  if (!points.intensity.empty()) fields.push_back({"intensity", &points.intensity});
  if (!points.time_s.empty()) fields.push_back({"time", &points.time_s});
  const auto count = static_cast<std::uint32_t>(points.x_m.size());
  const auto step = static_cast<std::uint32_t>(fields.size() * sizeof(float));
  std::vector<float> data(count * fields.size());
  for (std::size_t f = 0; f < fields.size(); ++f)
    for (std::size_t i = 0; i < count; ++i) data[i * fields.size() + f] = (*fields[f].values)[i];

  CdrWriter out;
  put_header(out, header);
  out.put(std::uint32_t{1});
  out.put(count);
  out.put(static_cast<std::uint32_t>(fields.size()));
  for (std::size_t f = 0; f < fields.size(); ++f)
  {
    out.text(fields[f].name);
    out.put(static_cast<std::uint32_t>(f * sizeof(float)));
    out.put(kFloat32);
    out.put(std::uint32_t{1});
  }
  out.put(std::uint8_t{__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__});
  out.put(step);
  out.put(step * count);
  out.sequence(reinterpret_cast<const char*>(data.data()), data.size() * sizeof(float));
  out.put(std::uint8_t{1});
  return out.bytes();
}

std::string grid_message(const Header& header, const Grid& grid)
{
  CdrWriter out;
  put_header(out, header);
  put_time(out, header.stamp_s);
  out.put(static_cast<float>(grid.resolution_m));
  out.put(static_cast<std::uint32_t>(grid.cells_x));
  out.put(static_cast<std::uint32_t>(grid.cells_y));
  put_pose(out, CPose3D(grid.min_x_m, grid.min_y_m, 0, 0, 0, 0));
  out.sequence(grid.cells.data(), grid.cells.size());
  return out.bytes();
}

std::string grid_update_message(const Header& header, const Grid& grid, int x, int y)
{
  CdrWriter out;
  put_header(out, header);
  out.put(static_cast<std::int32_t>(x));
  out.put(static_cast<std::int32_t>(y));
  out.put(static_cast<std::uint32_t>(grid.cells_x));
  out.put(static_cast<std::uint32_t>(grid.cells_y));
  out.sequence(grid.cells.data(), grid.cells.size());
  return out.bytes();
}

std::string path_message(const Header& header, const std::vector<std::pair<double, CPose3D>>& poses)
{
  CdrWriter out;
  put_header(out, header);
  out.put(static_cast<std::uint32_t>(poses.size()));
  for (const auto& [stamp_s, pose] : poses)
  {
    put_header(out, {stamp_s, header.frame});
    put_pose(out, pose);
  }
  return out.bytes();
}

}  // namespace talus::live
