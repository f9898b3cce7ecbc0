#pragma once
#include <talus/elevation_mapper.h>
#include <talus/point_labels.h>
#include "hand_over.h"
#include "window_tracker.h"
#include "kernels/9_channels.h"
#include "kernels/cell.h"

namespace talus
{
/** The parameters of a map as rules get them. */
struct MapConfig
{
  kernels::Config config;
  kernels::Body body;
  std::vector<ChannelRule> channels;
  /** kernels::kClasses scores for each channel; empty: no class costs. */
  std::vector<float> class_scores;
};
MapConfig make_config(const Parameters& p);

/** The persistent state of a map and its derived layers, as bytes on the host. */
struct MapBytes
{
  std::vector<std::uint8_t> cells;  //!< the arrays of CellStore, storage order, one after the other
  kernels::Datum datum;
  std::vector<float> features;  //!< the layers of stage 7, window order, one after the other
  /** The arrays of kernels::Channel, one channel after the other; empty in a saved map. */
  std::vector<kernels::ChannelValue> values;
  std::vector<kernels::ChannelVotes> votes;
};

/** The state of a map between two frames, as ElevationMapper::save() keeps it. */
struct SavedMap
{
  WindowTracker tracker;
  float reference_z_m = 0;  //!< reference of the heights of the last frame
  MapBytes map;  //!< empty before the first frame
};

std::vector<std::uint8_t> bytes_of(const SavedMap& saved, const Parameters& p);

/** Throws std::invalid_argument if the bytes are no state of a map with these parameters. */
SavedMap saved_map_from(const std::vector<std::uint8_t>& bytes, const Parameters& p);

/** The destination of one layer. */
struct OutputMemory
{
  float* mapped = nullptr;  //!< the caller's memory as kernels see it; null: the layer is only read
  bool direct = false;  //!< kernels write there; false: a copy follows
};

/** By channel: values of the points of a frame, as kernels see them, or null. */
using ChannelArrays = std::array<const float*, kMaxChannels>;

/** Cells handed over with a frame: of the window before it, and of its own. */
struct FrameRects
{
  std::vector<WindowRect> before, after;
};

/** By layer: the caller's n*n floats, or null. */
using OutputPointers = std::array<float*, kLayerCount>;

constexpr int kSlots = 2;  //!< frames that may be in flight: each has a slot

/** One map on one kind of device: the seven stages and their memory. */
class BackendInterface
{
 public:
  virtual ~BackendInterface() = default;

  /** Begins a frame in a free slot: its stages follow those of the frame before. `frame` gives the
   * points, `context` all else; both must stay in place until the frame is finished. Returns the
   * records of `cells`. Those of the window before are there, unless another frame is in flight;
   * the others are there after finish(). */
  virtual CellRecord* start(
      int slot, const Frame& frame, const kernels::FrameContext& context,
      const FrameRects& cells) = 0;
  /** Ends the frame that was started first; `cells` are those of its start(). */
  virtual FrameReport finish(int slot, const FrameRects& cells) = 0;

  /** Room for points in a free slot, which start() need not copy; valid until it grows. */
  virtual PointArrays point_arrays(int slot, std::size_t size) = 0;

  /** From now on the frames of a slot, and write_all(), put these layers into the caller's memory,
   * which must stay in place until other outputs are set. Returns which layers they deliver. A slot
   * has no outputs at first. */
  virtual std::array<bool, kLayerCount> set_outputs(int slot, const OutputPointers& host) = 0;

  // ---- the following need that no frame is in flight ----
  virtual void read_layer(Layer layer, float* out) = 0;
  /** See ElevationMapper::read_cells(). */
  virtual CellRecord* read_cells(const std::vector<WindowRect>& rects) = 0;
  /** See ElevationMapper::write_cells(); also writes into the delivered layers. */
  virtual void write_cells(const std::vector<WindowRect>& rects, const CellRecord* from) = 0;
  /** A label for each point of a frame; `context` has its poses in the window of the map. */
  virtual std::vector<PointLabel> label_points(
      const Frame& frame, const kernels::FrameContext& context) = 0;
  /** See ElevationMapper::read_channels(). */
  virtual const ChannelRecord* read_channels(const std::vector<WindowRect>& rects) = 0;
  /** See ElevationMapper::write_channels(). */
  virtual void write_channels(const std::vector<WindowRect>& rects, const ChannelRecord* from) = 0;
  /** One surface of a channel, in window order. */
  virtual void read_channel(std::size_t channel, int surface, float* out) = 0;
  virtual MapBytes read_all() = 0;
  /** Fills a backend that has seen no frame; the channels if they are given. The caller checks the
   * sizes. */
  virtual void write_all(MapBytes bytes, const kernels::FrameContext& window) = 0;

  virtual std::string name() const = 0;
};

std::unique_ptr<BackendInterface> make_cpu_backend(const MapConfig& config, int threads);

/** Throws std::runtime_error with the reason where there is no such device. */
std::unique_ptr<BackendInterface> make_cuda_backend(const MapConfig& config, int device);

}  // namespace talus
