#pragma once
#include <talus/cell_record.h>
#include <talus/frame.h>
#include <talus/frame_report.h>
#include <talus/layers.h>
#include <talus/parameters.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace talus
{
enum class PointLabel : std::uint32_t;

enum class Backend
{
  Auto,  //!< CUDA if a device answers, else CPU
  Cpu,
  Cuda
};

/** The default number of threads: one for each core. The bits are those of one thread. */
constexpr int kAllCores = 0;

/** Devices for the CUDA backend; 0 without it. It starts CUDA, which fails after a later fork(). */
int cuda_devices();

/** The map: feed it frames, read its layers. Not thread safe.
 *
 * The same frames give the same bits in every layer, whatever the backend, the number of threads or
 * the order of the points in a frame. */
class ElevationMapper
{
 public:
  /** Throws std::invalid_argument if a parameter is out of range, std::runtime_error if `backend`
   * is Cuda and there is no usable device. `threads`: of the CPU backend, 1 to 1024 (more count as
   * 1024) or kAllCores; a program whose other threads need the cores passes 1. `device`: of the
   * CUDA backend, below cuda_devices(); any thread may call. */
  explicit ElevationMapper(
      const Parameters& parameters = {}, Backend backend = Backend::Auto, int threads = kAllCores,
      int device = 0);
  /** A map from the `state` that save() returned. Throws as the other constructor and restore(),
   * before it allocates a window that does not belong to the state. */
  ElevationMapper(
      const Parameters& parameters, const std::vector<std::uint8_t>& state,
      Backend backend = Backend::Auto, int threads = kAllCores, int device = 0);
  ~ElevationMapper();
  /** A map that was moved from can only be assigned to or destroyed. */
  ElevationMapper(ElevationMapper&&) noexcept;
  /** See the move constructor. */
  ElevationMapper& operator=(ElevationMapper&&) noexcept;

  /** Runs the seven stages on one frame: start() and finish(). Throws as they do, and
   * std::logic_error while a frame is in flight. */
  FrameReport update(const Frame& frame);
  /** Runs a frame and also hands over cells, as read_cells() does, from before and after it: on a
   * device they come with the frame at hardly any extra time. Meanwhile `meanwhile` may work on the
   * records from before; it must not use the map. Throws as read_cells() does, then nothing has
   * changed; after the frame it rethrows what `meanwhile` throws. */
  FrameReport update(
      const Frame& frame, FrameCells& cells, const std::function<void()>& meanwhile = {});

  /** A foot that stands at (x, y, z) of the map frame [m], with the standard deviation of z [m]:
   * one more point of stage 3 (eq. 5 to 7), in the last frame. It moves a height of a measured cell
   * whose gate it is in by v / (v + sigma^2) of the difference, v the variance of that height.
   * Beyond the gate a lower one becomes the ground, and a higher one the top of what stands. A cell
   * that was not measured is so from then on. layer() shows it as after write_cells(). Throws
   * std::invalid_argument for a height beyond 100 km, a deviation that is not finite and
   * positive, or a position outside of the window (all are, before the first frame), then nothing
   * has changed; std::logic_error while a frame is in flight. */
  void contact(double x_m, double y_m, double z_m, double sigma_m);

  /** @name Two frames in flight
   * To overlap frames: start() the next one, then finish() the one before and read its layers.
   * A device then receives points and sends layers while it computes; the CPU backend does all in
   * finish(). The layers have the same bits as those of update().
   *
   * A frame is in flight from start() to finish(). window(), empty() and layer() belong to the
   * frame that was finished last. Calls that read or replace the whole map (save(), restore(),
   * clear(), set_output_layers()) throw std::logic_error while a frame is in flight. The map
   * allocates memory for a second frame when it is first used. @{ */

  /** Begins a frame. The memory of its points must stay unchanged until its finish() has returned;
   * its path may go at once. Throws std::invalid_argument for more than 536,870,911 points or
   * points without coordinates, for a pose (of the sensor or in the path) that is not finite, no
   * rigid transform, or farther from the origin than 1e9 cells in x or y or 100 km in z, and for a
   * path whose times are not finite or descend, or as require_channels(); std::logic_error if two
   * frames are in flight. Then nothing has changed. */
  void start(const Frame& frame);
  /** Ends the frame that was started first. Throws std::logic_error if none is in flight. */
  FrameReport finish();
  /** The number of frames in flight: 0, 1 or 2. */
  int frames_in_flight() const;
  /** @} */

  /** Memory for `size` points, from which a device takes them without a copy, if the pointers of
   * the frame are these arrays. It serves the next update() or start(): ask for each frame. Valid
   * until a larger frame comes, or clear(), restore() or set_output_layers(). Throws
   * std::logic_error if two frames are in flight. Optional: points from other memory are copied. */
  PointArrays point_arrays(std::size_t size);

  /** Selects the layers that each frame delivers, so that layer() is free of cost; layer() makes
   * others on demand. None at first. Best set before the first frame. */
  void set_output_layers(const std::vector<Layer>& layers);
  /** The layers that set_output_layers() selected. */
  std::vector<Layer> output_layers() const;

  /** Clears the map. */
  void clear();

  /** True until the first frame. */
  bool empty() const;

  /** One layer, window().cells^2 floats, row by row: index = iy * cells + ix; MapView::at() finds
   * the value at a position. NaN: unknown, or a score that was not judged. Valid until the next
   * start() or another call that changes the map. Made on demand if set_output_layers() did not
   * select it. Throws std::logic_error while a frame is in flight for layers that are not selected,
   * and between start() and the next finish() for all. */
  const std::vector<float>& layer(Layer l) const;

  /** A layer of the channels of Parameters::channels, by one of channel_layer_names(): the values
   * of the ground of each cell, or of what stands there, else as layer(). NaN: no point of it had a
   * value, or nothing stands. Read on demand. Throws std::invalid_argument for another name,
   * std::logic_error while a frame is in flight. */
  const std::vector<float>& channel(const std::string& name) const;

  /** The position of the cells of layer(); around the origin before the first frame. */
  Window window() const;
  /** The parameters of this map. */
  const Parameters& parameters() const;
  /** "cpu" or "cuda: NAME OF THE DEVICE", of several devices with " (device 1 of 2)". */
  std::string backend_name() const;

  /** All persistent state but for channels: a map restored from it goes on with the same bits. */
  std::vector<std::uint8_t> save() const;
  /** Sets the state that save() of this or another map returned. Throws std::invalid_argument if it
   * is none or of another window size or resolution; then nothing has changed. */
  void restore(const std::vector<std::uint8_t>& bytes);

  /** The window that update() of this frame will have. Throws as start() does. */
  Window window_after(const Frame& frame) const;
  /** The records of cells that are all in the window, row by row, one rectangle after the other, to
   * store them before they leave it. Valid until cells are read or written or the map changes.
   * Throws std::invalid_argument for cells outside, std::logic_error while a frame is in flight. */
  CellRecords read_cells(const std::vector<CellRect>& rects) const;
  /** Writes `size` records, from any memory, into the map; unknown records change nothing. layer()
   * shows them at once, slope, step, roughness and sparsity from the next frame on. Throws as
   * read_cells() does, and std::invalid_argument if `size` is not the number of cells. */
  void write_cells(const std::vector<CellRect>& rects, const CellRecord* records, std::size_t size);

  /** The values of the channels of cells, else as read_cells(); null where the map has no channels,
   * or there are no cells. Valid until channels of cells are read or written again. */
  const ChannelRecord* read_channels(const std::vector<CellRect>& rects) const;
  /** Writes values of channels, from any memory, where the map has none yet: each counts as one
   * point. NaN changes nothing. Else as write_cells(). */
  void write_channels(
      const std::vector<CellRect>& rects, const ChannelRecord* records, std::size_t size);

  /** Whether save() gives so many bytes of a map with these parameters that has seen a
   * frame: to be asked before they are read from a file. Throws
   * std::invalid_argument if a parameter is out of range. */
  static bool is_size_of_state(std::uint64_t bytes, const Parameters& parameters);

 private:
  friend std::vector<PointLabel> label_points(const ElevationMapper& map, const Frame& frame);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus
