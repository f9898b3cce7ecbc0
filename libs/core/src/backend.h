#pragma once
#include <talus/elevation_mapper.h>
#include "map_config.h"
#include "hand_over.h"
#include "kernels/cell.h"
#include "kernels/frame.h"

namespace talus
{
/** The persistent state of a map and its derived layers, as bytes on the host. */
struct MapBytes
{
  std::vector<std::uint8_t> cells;  //!< the arrays of CellStore, storage order, one after the other
  kernels::Datum datum;
  std::vector<float> features;  //!< the arrays of FeatureLayers, window order, one after the other
};

/** Where a backend puts one layer for its caller. */
struct OutputMemory
{
  /** The caller's memory as kernels see it; null: the layer cannot be delivered with each frame,
   * only read. */
  float* mapped = nullptr;
  bool direct = false;  //!< kernels put it there; false: they work elsewhere, and it is copied
};

/** Cells that a frame hands over: of the window before it, and of its own. */
struct FrameRects
{
  std::vector<WindowRect> before, after;
};

/** By layer: the caller's n*n floats, or null. */
using OutputPointers = std::array<float*, kLayerCount>;

/** Frames that may be in flight: each has a slot, with what it does not share with the other. */
constexpr int kSlots = 2;

/** One map on one kind of device: the seven stages on its own memory. */
class BackendInterface
{
 public:
  virtual ~BackendInterface() = default;

  /** Begins a frame in a slot that is free: the stages, after those of the frame before. `frame`
   * gives the points, `context` all else; both stay where they are until it is finished. Returns
   * the records of `cells`, none where another frame is in flight: those of before are there, those
   * behind them when it is finished. */
  virtual CellRecord* start(
      int slot, const Frame& frame, const kernels::FrameContext& context,
      const FrameRects& cells) = 0;
  /** Ends the frame that was started first, with the same cells. */
  virtual FrameReport finish(int slot, const FrameRects& cells) = 0;

  /** Room for points that start() need not copy, in a slot that is free; valid until it grows. */
  virtual PointArrays point_arrays(int slot, std::size_t size) = 0;

  /** From now on the frames of a slot, and write_all() with the first, leave these layers in the
   * caller's memory, which must stay where it is until other outputs are set. Returns for which
   * layers they do. A slot has none before this was called. */
  virtual std::array<bool, kLayerCount> set_outputs(int slot, const OutputPointers& host) = 0;

  // ---- while no frame is in flight ----
  /** Copies a layer, window order, n*n floats. */
  virtual void read_layer(Layer layer, float* out) = 0;
  /** Cells of rectangles, row by row, one after the other; see ElevationMapper::read_cells(). */
  virtual CellRecord* read_cells(const std::vector<WindowRect>& rects) = 0;
  /** Also into the layers that are delivered. */
  virtual void write_cells(const std::vector<WindowRect>& rects, const CellRecord* from) = 0;
  virtual MapBytes read_all() = 0;
  /** Of a backend that has seen no frame. Sizes are checked by the caller. */
  virtual void write_all(const MapBytes& bytes, const kernels::FrameContext& window) = 0;

  virtual std::string name() const = 0;
};

std::unique_ptr<BackendInterface> make_cpu_backend(const MapConfig& config, int threads);

/** On the device of that number, which is below cuda_devices() or 0. Throws std::runtime_error that
 * says why where there is no usable device. */
std::unique_ptr<BackendInterface> make_cuda_backend(const MapConfig& config, int device);

}  // namespace talus
