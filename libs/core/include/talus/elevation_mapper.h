#pragma once
#include <talus/cell_record.h>
#include <talus/frame.h>
#include <talus/frame_report.h>
#include <talus/layers.h>
#include <talus/parameters.h>
#include <talus/window.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace talus
{
enum class Backend
{
  Auto,  //!< CUDA where a device answers, else CPU
  Cpu,
  Cuda
};

/** The default number of threads, everywhere: as many as the machine has cores. The bits are those
 * of one thread. */
constexpr int kAllCores = 0;

/** How many devices there are for the CUDA backend; 0 also in a build without it. Starts CUDA in
 * this process, whose fork() cannot use it then. */
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
   * 1024) or kAllCores; a program whose other threads need the cores says 1. `device`: of the CUDA
   * backend, below cuda_devices(); any thread may call. */
  explicit ElevationMapper(
      const Parameters& parameters = {}, Backend backend = Backend::Auto, int threads = kAllCores,
      int device = 0);
  /** The map of which save() gave `state`. Throws as above and as restore(), before it takes memory
   * for a window that the state is none of. */
  ElevationMapper(
      const Parameters& parameters, const std::vector<std::uint8_t>& state,
      Backend backend = Backend::Auto, int threads = kAllCores, int device = 0);
  ~ElevationMapper();
  /** What was moved from can only be assigned to or destroyed. */
  ElevationMapper(ElevationMapper&&) noexcept;
  /** As the constructor. */
  ElevationMapper& operator=(ElevationMapper&&) noexcept;

  /** Runs the seven stages on one frame: start() and finish(). Throws as they do, and
   * std::logic_error while a frame is in flight. */
  FrameReport update(const Frame& frame);
  /** The same, and read_cells() of some as the frame finds them and of others as it leaves them: on
   * a device they come with the frame, for hardly any time of their own. While it computes,
   * `meanwhile` may work on those of before; it must leave the map alone. Throws also as
   * read_cells(), then nothing has changed, and after the frame what `meanwhile` throws. */
  FrameReport update(
      const Frame& frame, FrameCells& cells, const std::function<void()>& meanwhile = {});

  /** @name Two frames in flight
   * To overlap frames: start() the next one, then finish() the one before and read its layers.
   * A device then receives points and sends layers while it computes; the CPU backend does all in
   * finish(). The layers have the bits that update() gives.
   *
   * In flight is what was started and not finished. window(), empty() and layer() are of the frame
   * that was finished last; what reads or replaces the whole map (save(), restore(), clear(),
   * set_output_layers()) throws std::logic_error while a frame is in flight. The first time that a
   * second one is, the map allocates what it needs for it. @{ */

  /** Begins a frame. The memory of its points must stay as it is until its finish() has returned;
   * its path is not needed any longer. Throws std::invalid_argument for more than 536,870,911
   * points or points without coordinates, for a pose (of the sensor or in the path) that is not
   * finite, no rigid transform, or farther from the origin than 1e9 cells in x or y or 100 km in z,
   * and for a path whose times are not finite or descend; std::logic_error if two frames are in
   * flight. Then nothing has changed. */
  void start(const Frame& frame);
  /** Ends the frame that was started first. Throws std::logic_error if none is in flight. */
  FrameReport finish();
  /** 0, 1 or 2 */
  int frames_in_flight() const;
  /** @} */

  /** Room for `size` points from which they reach the device without a further copy: a frame whose
   * pointers are these arrays is taken from there. It is for the next update() or start(), and
   * while that frame is in flight the next one has other room: ask anew for each. Valid until a
   * larger frame comes, or clear(), restore() or set_output_layers(). Throws std::logic_error if
   * two frames are in flight. Optional: points from anywhere else are copied. */
  PointArrays point_arrays(std::size_t size);

  /** Layers that each frame delivers: layer() of them costs nothing afterwards. The others are made
   * when layer() asks for them. None at first. Best set before the first frame. */
  void set_output_layers(const std::vector<Layer>& layers);
  /** Those that set_output_layers() named. */
  std::vector<Layer> output_layers() const;

  /** Forgets everything. */
  void clear();

  /** True until the first frame. */
  bool empty() const;

  /** One layer, window().cells^2 floats, row by row: index = iy * cells + ix; MapView::at() finds
   * the value at a place. Unknown, and of scores not judged, is NaN. Valid until the next start()
   * or other call that changes the map. Made on first use where set_output_layers() does not name
   * it. Throws std::logic_error for what cannot be read while a frame is in flight: those that it
   * does not name, and all between start() and the next finish(). */
  const std::vector<float>& layer(Layer l) const;

  /** Where the cells of layer() lie; before the first frame around the origin. */
  Window window() const;
  /** Those that it was made with. */
  const Parameters& parameters() const;
  /** "cpu" or "cuda: NAME OF THE DEVICE", where there are several with " (device 1 of 2)" */
  std::string backend_name() const;

  /** The whole persistent state: a map restored from it goes on with the same bits. */
  std::vector<std::uint8_t> save() const;
  /** What save() gave, of this map or another. Throws std::invalid_argument when the bytes are not
   * such a state or belong to another window size or resolution; then nothing has changed. */
  void restore(const std::vector<std::uint8_t>& bytes);

  /** Where the window will lie when update() has taken a frame. Throws as start() does. */
  Window window_after(const Frame& frame) const;
  /** What the map remembers of cells that are all in the window, row by row, one rectangle after
   * the other: to be kept before they leave it. Valid until cells are read or written again or the
   * map changes. Throws std::invalid_argument where they are not, std::logic_error while a frame is
   * in flight. */
  CellRecords read_cells(const std::vector<CellRect>& rects) const;
  /** And back: those of `size` records, from anywhere, that are not unknown replace what the map
   * has there; layer() shows them at once, and what traversability is made of from the next frame
   * on. Throws as read_cells(), and std::invalid_argument where there are not as many records as
   * cells.
   */
  void write_cells(const std::vector<CellRect>& rects, const CellRecord* records, std::size_t size);

  /** Whether save() gives so many bytes of a map with these parameters that has seen a
   * frame: to be asked before they are read from a file. Throws
   * std::invalid_argument if a parameter is out of range. */
  static bool is_size_of_state(std::uint64_t bytes, const Parameters& parameters);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus
