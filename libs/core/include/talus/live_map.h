#pragma once
#include <talus/elevation_mapper.h>
#include <talus/frame_gatherer.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace talus
{
/** Some layers of a map after one frame. Never changes. */
struct MapSnapshot
{
  /** 1 for the first frame of the live map. clear() does not reset it, so that two snapshots of one
   * live map never have the same number. */
  std::uint64_t frame = 0;
  Pose T_map_sensor;  //!< of that frame
  FrameReport report;  //!< of that frame; has its stamp
  Window window;  //!< position of the cells of the layers
  Parameters parameters;  //!< parameters of the live map
  std::array<std::vector<float>, kLayerCount> layers;  //!< empty: not selected
  std::vector<std::vector<float>> channels;  //!< in the order of channel_layer_names()

  /** One layer of a channel, see ElevationMapper::channel(). Throws std::invalid_argument. */
  const std::vector<float>& channel(const std::string& name) const;
  /** One layer, see ElevationMapper::layer(). Throws std::invalid_argument with the name of the
   * layer if the live map was made without it. */
  const std::vector<float>& layer(Layer l) const;
};

/** Frames of a live map since it was made, by their FrameOrder; clear() does not reset them. */
struct LiveCounts
{
  std::uint64_t mapped = 0;  //!< with those of ClockSetBack; parts of a scan count one by one
  /** frames that were not mapped */
  std::uint64_t duplicate = 0, late = 0;
  std::uint64_t clock_set_back = 0;  //!< mapped frames that were the first after the step
};

/** A map that some threads feed while others read it.
 *
 * A reader gets the map as it was after the newest complete frame and keeps it as long as it likes,
 * whatever the map does meanwhile. Neither waits for the other: what both take a lock for is to
 * exchange a pointer. A frame costs one copy of the wanted layers more than ElevationMapper; memory
 * is that of two snapshots, and one more for each that is held while newer frames come. No heap per
 * frame once warm.
 *
 * The frames of each sensor (Frame::sensor) reach the map in the order of their stamps: duplicates
 * and late frames are dropped and counted, since they would count a measurement twice, or roll the
 * window back and show what moved where it was. See FrameOrder. Frames that are parts of a scan are
 * gathered, see FrameGatherer: a snapshot comes with the last of them. */
class LiveMap
{
 public:
  /** Snapshots have these `layers` and all channels. Else as ElevationMapper and FrameSequence. */
  LiveMap(
      const Parameters& parameters, const std::vector<Layer>& layers,
      Backend backend = Backend::Auto, int threads = kAllCores, double max_late_s = 1.0,
      int device = 0);
  ~LiveMap();

  /** Maps or gathers a frame, unless it is a Duplicate or Late, and publishes the result. From any
   * thread; several take turns. Throws as ElevationMapper::update() and FrameSequence::next(), and
   * then nothing has changed. */
  FrameOrder ingest(const Frame& frame);

  /** The map after the newest frame; nullptr before the first. Any thread may call. */
  std::shared_ptr<const MapSnapshot> snapshot() const;

  /** The counts so far. Any thread may call. */
  LiveCounts counts() const;

  /** Clears the map and the time of its last frame; snapshot() is nullptr again. Snapshots of
   * readers stay valid. MapSnapshot::frame and counts() go on. */
  void clear();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus
