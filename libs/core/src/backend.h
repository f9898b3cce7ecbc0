#pragma once
#include <talus/elevation_mapper.h>
#include "frame_context.h"

#include <functional>

namespace talus
{
/** The persistent state of a map and its derived layers, as bytes on the host. */
struct MapBytes
{
  std::vector<std::uint8_t> cells;  //!< the arrays of CellStore, storage order, one after the other
  std::vector<float> features;  //!< the arrays of FeatureLayers, window order, one after the other
};

/** One map on one kind of device: the nine stages on its own memory. */
class BackendInterface
{
 public:
  virtual ~BackendInterface() = default;

  /** Runs the stages. `frame` gives the points, `context` all else. */
  virtual FrameReport run(const Frame& frame, const kernels::FrameContext& context) = 0;

  /** Copies a layer, window order, n*n floats. */
  virtual void read_layer(Layer layer, float* out) = 0;

  virtual MapBytes read_all() = 0;
  /** Sizes are checked by the caller. */
  virtual void write_all(const MapBytes& bytes, const kernels::FrameContext& window) = 0;

  virtual std::string name() const = 0;
};

std::unique_ptr<BackendInterface> make_cpu_backend(const kernels::Config& config, int threads);

/** Throws std::runtime_error that says why where there is no usable device. */
std::unique_ptr<BackendInterface> make_cuda_backend(const kernels::Config& config);

}  // namespace talus
