#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <talus/hints/hint_finder.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "warn_once.h"
#include "whole_map.h"

namespace talus
{
namespace
{
constexpr std::size_t kFirstLook = 32, kLastLook = 1024;  // frames, for hints
constexpr std::size_t kFramesToFill = 256;  // before a window that was hardly seen is strange

constexpr double kLevel_rad = 5 * M_PI / 180;

/** A scanner that nods during the scan, or is tilted, sees heights. */
bool is_level_scan(const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& T_map_sensor)
{
  const auto* scan = dynamic_cast<const mrpt::obs::CObservation2DRangeScan*>(&obs);
  return scan && std::abs(scan->deltaPitch) < kLevel_rad &&
         std::abs(T_map_sensor.getRotationMatrix()(2, 2)) > std::cos(kLevel_rad);
}

/** As programs make them of several scans, such as FilterMerge of mp2p_icp. */
bool is_merged(const mrpt::obs::CObservation& obs)
{
  const auto* cloud = dynamic_cast<const mrpt::obs::CObservationPointCloud*>(&obs);
  return cloud && cloud->sensorLabel.empty() && cloud->sensorPose == mrpt::poses::CPose3D();
}

bool same_parameters(const Parameters& a, const Parameters& b)
{
  const auto& table = parameter_table();
  return std::all_of(
      table.begin(), table.end(), [&](const auto& info) { return is_same_value(info, a, b); });
}
}  // namespace

Pose pose_from(const mrpt::poses::CPose3D& pose)
{
  const auto& R = pose.getRotationMatrix();
  Pose out;
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 3; column++) out.m[4 * row + column] = R(row, column);
  out.m[3] = pose.x();
  out.m[7] = pose.y();
  out.m[11] = pose.z();
  return out;
}

mrpt::poses::CPose3D to_mrpt(const Pose& T)
{
  mrpt::math::CMatrixDouble33 R;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) R(r, c) = T.m[static_cast<std::size_t>(4 * r + c)];
  return {R, mrpt::math::CMatrixDouble31({T.x(), T.y(), T.z()})};
}

Frame frame_from(const SensorPoints& points, const mrpt::poses::CPose3D& T_map_base)
{
  Frame frame;
  frame.stamp_s = points.stamp_s;
  frame.T_map_sensor = pose_from(T_map_base + points.T_base_sensor);
  frame.T_base_sensor = pose_from(points.T_base_sensor);
  frame.x_m = points.x_m.data();
  frame.y_m = points.y_m.data();
  frame.z_m = points.z_m.data();
  frame.size = points.x_m.size();
  frame.time_s = points.time_s.empty() ? nullptr : points.time_s.data();
  for (std::size_t c = 0; c < std::min(points.channels.size(), kMaxChannels); ++c)
    if (!points.channels[c].empty()) frame.channels[c] = points.channels[c].data();
  return frame;
}

bool CDualElevationMap::internal_insertObservation(
    const mrpt::obs::CObservation& obs, const std::optional<const mrpt::poses::CPose3D>& robotPose)
{
  const std::string type = obs.GetRuntimeClass()->className;
  try
  {
    m_scratch.channel_names.clear();
    for (const Channel& channel : insertionOptions.channels)
      m_scratch.channel_names.push_back(channel.name);
    if (!points_from_observation(obs, m_scratch))
    {
      detail::warn_once(type + " holds no points that this map understands: ignored");
      return false;
    }
    const auto T_map_base = robotPose ? *robotPose : mrpt::poses::CPose3D();
    insertPoints(m_scratch, T_map_base);
    if (is_level_scan(obs, T_map_base + m_scratch.T_base_sensor))
      detail::warn_once("a level 2D scan shows no terrain: what it hits counts as ground");
    if (is_merged(obs))
      detail::warn_once(
          "hint: a cloud has neither sensorLabel nor sensorPose: its rays begin at the robot, on "
          "the ground. A merged cloud has no viewpoint: insert each scan with its own poses "
          "(sm2mm: in `generators`, not by FilterMerge)");
    return true;
  }
  catch (const std::exception& e)
  {
    detail::warn_once(type + " not inserted: " + e.what(), "not inserted: " + type);
    return false;
  }
}

void CDualElevationMap::insertPoints(
    const SensorPoints& points, const mrpt::poses::CPose3D& T_map_base)
{
  applyOptions();
  Frame frame = frame_from(points, T_map_base);
  frame.sensor = m_sensors.number_of(points.sensor_label);
  m_lastReport = m_keep_whole ? whole().update(mapper(), frame) : mapper().update(frame);
  m_T_map_base = T_map_base;
  watch(frame, points.sensor_label);
}

std::vector<PointLabel> CDualElevationMap::labelPoints(
    const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& robotPose) const
{
  SensorPoints points;
  if (!points_from_observation(obs, points)) return {};
  return label_points(mapper(), frame_from(points, robotPose));
}

/** Looks for hints after 32, 64, 128 ... frames, until there is any, or up to 1024 frames. */
void CDualElevationMap::watch(const Frame& frame, const std::string& sensor)
{
  if (m_hintsDone) return;
  if (!m_hints) m_hints = std::make_unique<hints::HintFinder>(mapper().parameters());
  m_hints->add(frame, sensor, m_lastReport);
  const std::size_t frames = m_hints->frames();
  if (frames < kFirstLook || (frames & (frames - 1)) != 0) return;
  const auto& state = m_mapper->layer(Layer::State);
  const auto known = std::count_if(state.begin(), state.end(), [](float s) { return s > 0; });
  const double known_share = frames < kFramesToFill
                                 ? std::nan("")
                                 : static_cast<double>(known) / static_cast<double>(state.size());
  const auto found = m_hints->find(known_share);
  for (const auto& hint : found)
    detail::warn_once("hint: " + hint.text, "hint " + std::to_string(static_cast<int>(hint.kind)));
  m_hintsDone = !found.empty() || frames >= kLastLook;
  if (m_hintsDone) m_hints.reset();
}

void CDualElevationMap::applyOptions()
{
  if (!m_mapper || same_parameters(insertionOptions, m_mapper->parameters())) return;
  ElevationMapper changed(insertionOptions, m_backend, m_threads, m_device);
  changed.set_output_layers(m_mapper->output_layers());
  const Window before = m_mapper->window(), after = changed.window();
  const bool same_cells = before.cells == after.cells && before.resolution_m == after.resolution_m;
  if (same_cells && !m_mapper->empty()) changed.restore(m_mapper->save());
  if (m_whole && before.resolution_m != after.resolution_m) m_whole.reset();
  if (m_whole && !same_cells) m_whole->site(*m_mapper);  // keeps what is in the window
  *m_mapper = std::move(changed);
  m_hints.reset();  // what it has seen may be right by now
}

mrpt::maps::CPointsMap::Ptr labelled_cloud(
    const SensorPoints& points, const std::vector<PointLabel>& labels)
{
  const std::size_t size = points.x_m.size();
  if (labels.size() != size)
    throw std::invalid_argument("labelled_cloud: there must be a label for each point");
  const auto cloud = detail::make_cloud_with_intensity(size);
  for (std::size_t i = 0; i < size; i++)
  {
    cloud->setPointFast(i, points.x_m[i], points.y_m[i], points.z_m[i]);
    detail::set_intensity(*cloud, i, static_cast<float>(labels[i]));
  }
  return cloud;
}

}  // namespace talus
