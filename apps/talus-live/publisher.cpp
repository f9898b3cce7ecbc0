#include "publisher.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <talus/formats/convert.h>
#include <talus/formats/write.h>
#include <talus/live/messages.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace talus::app
{
namespace
{
constexpr live::Quality kKept{true, true, 1}, kLast{true, false, 5};

constexpr double kWholeEvery_s = 1;  //!< by the clock of the frames

constexpr const char* kGridType = "nav_msgs/msg/OccupancyGrid";
}  // namespace

Publisher::Publisher(live::Participant& network, std::vector<std::string> layers)
    : layers_(std::move(layers)),
      map_(network, "/talus/map", kGridType, kKept),
      map_updates_(network, "/talus/map_updates", "map_msgs/msg/OccupancyGridUpdate", kLast),
      window_(network, "/talus/window", kGridType, kKept),
      obstacles_(network, "/talus/obstacles", "sensor_msgs/msg/PointCloud2", kLast),
      path_(network, "/talus/path", "nav_msgs/msg/Path", kKept),
      grid_map_(network, "/talus/grid_map", "grid_map_msgs/msg/GridMap", kKept)
{
}

std::vector<Layer> Publisher::layers() const
{
  std::set<Layer> all = {
      Layer::Traversability, Layer::State, Layer::GroundElevation, Layer::Elevation};
  for (int i = 0; i < kLayerCount; ++i)
    if (std::find(layers_.begin(), layers_.end(), kLayerTable[i].name) != layers_.end())
      all.insert(static_cast<Layer>(i));
  return {all.begin(), all.end()};
}

io::LayerStack Publisher::window_of(const DriveMap& map) const
{
  const Window w = map.window().window();
  io::LayerStack stack;
  stack.cells_x = stack.cells_y = w.cells;
  stack.resolution_m = w.resolution_m;
  stack.min_x_m = w.min_x_m();
  stack.min_y_m = w.min_y_m();
  for (const Layer layer : layers())
  {
    stack.names.emplace_back(layer_name(layer));
    stack.layers.push_back(map.window().layer(layer));
  }
  return stack;
}

io::LayerStack Publisher::publish_window(const DriveMap& map, const std::string& frame)
{
  io::LayerStack window = window_of(map);
  const live::Grid grid{window.cells_x, window.cells_y, window.resolution_m,
                        window.min_x_m, window.min_y_m, formats::ros_cells(window, kOccupancy)};
  window_.write(live::grid_message({map.stamp_s(), frame}, grid));
  return window;
}

void Publisher::publish_rest(DriveMap& map, const io::LayerStack& window, const std::string& frame)
{
  const live::Header header{map.stamp_s(), frame};
  if (obstacles_.subscribers() > 0)
  {
    mrpt::maps::CSimplePointsMap points;
    formats::to_points(window, formats::Surface::Standing, points);
    live::CloudPoints cloud;
    const auto copy = [](const auto& from) { return std::vector<float>(from.begin(), from.end()); };
    cloud.x_m = copy(points.getPointsBufferRef_x());
    cloud.y_m = copy(points.getPointsBufferRef_y());
    cloud.z_m = copy(points.getPointsBufferRef_z());
    obstacles_.write(live::cloud_message(header, cloud));
  }
  if (!layers_.empty())
    grid_map_.write(formats::grid_map_message(header.stamp_s, header.frame, window, layers_));
  note_pose(map.stamp_s(), map.base());
  if (std::abs(header.stamp_s - whole_s_) < kWholeEvery_s) return;
  whole_s_ = header.stamp_s;
  whole_.update(
      map.site().tiles, map.floor(), map.window().window(),
      formats::ros_cells(window, {kOccupancy.blocked_at, 0.0}));
  path_.write(live::path_message(header, poses_));
  publish_whole(map, header);
}

/** All of it where it has grown or somebody new listens, else what has changed. */
void Publisher::publish_whole(DriveMap& map, const live::Header& header)
{
  const auto& area = whole_.area();
  const auto changed = whole_.take_changed();
  const double resolution_m = map.site().resolution_m;
  const bool is_new = std::exchange(map_listeners_, map_.subscribers()) < map_.subscribers();
  if (is_new || area.min_x != published_.min_x || area.min_y != published_.min_y ||
      area.end_x != published_.end_x || area.end_y != published_.end_y)
  {
    published_ = area;
    map_.write(live::grid_message(header, whole_.cells(area, resolution_m)));
  }
  else if (!changed.empty() && map_updates_.subscribers() > 0)
    map_updates_.write(live::grid_update_message(
        header, whole_.cells(changed, resolution_m), static_cast<int>(changed.min_x - area.min_x),
        static_cast<int>(changed.min_y - area.min_y)));
}

void Publisher::begin_anew(WholeGrid whole, const std::vector<io::Trajectory::Entry>& poses)
{
  whole_ = std::move(whole);
  published_ = {};
  poses_.clear();
  for (const auto& pose : poses) note_pose(pose.time_s, pose.T_map_base);
}

/** About four a metre; of a long drive every second one. */
void Publisher::note_pose(double stamp_s, const mrpt::poses::CPose3D& T_map_base)
{
  constexpr double kApart_m = 0.25;
  constexpr std::size_t kMax = 5000;
  if (!poses_.empty() && poses_.back().second.distanceTo(T_map_base) < kApart_m) return;
  poses_.emplace_back(stamp_s, T_map_base);
  if (poses_.size() < kMax) return;
  for (std::size_t i = 0; i < kMax / 2; ++i) poses_[i] = poses_[2 * i];
  poses_.resize(kMax / 2);
}

}  // namespace talus::app
