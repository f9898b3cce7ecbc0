#pragma once
#include "cuda/copy_large.h"
#include "cuda/executor.cuh"

namespace talus
{
namespace
{
constexpr std::size_t kContextWords = sizeof(kernels::FrameContext) / sizeof(std::uint32_t);
constexpr std::size_t kStagedPoints = (kContextWords + 63) / 64 * 64;  //!< where the arrays begin
/** Up to so many bytes the accepting kernel reads points from host memory. The bus copies larger
 * frames, each array while the next one is staged. */
constexpr std::size_t kReadBytes = 512 * 1024;
/** Up to so many bytes of layers are written to host memory by their kernels; the rest is copied.
 */
constexpr std::size_t kDirectBytes = 1024 * 1024;
}  // namespace

inline CudaExecutor::CudaExecutor(int number) : device_{number}
{
  int devices = 0;
  const cudaError_t answer = cudaGetDeviceCount(&devices);
  static_cast<void>(cudaGetLastError());
  if (answer != cudaSuccess || devices == 0)
    throw std::runtime_error(
        std::string("no CUDA device answers") +
        (answer == cudaSuccess ? "" : std::string(": ") + cudaGetErrorString(answer)));
  TALUS_CUDA(cudaSetDevice(number));
  cudaDeviceProp device;
  TALUS_CUDA(cudaGetDeviceProperties(&device, number));
  name_ = std::string("cuda: ") + device.name;
  if (devices > 1)
    name_ += " (device " + std::to_string(number) + " of " + std::to_string(devices) + ")";
  cudaFuncAttributes code;
  if (cudaFuncGetAttributes(&code, loops::fetch) != cudaSuccess)
  {
    static_cast<void>(cudaGetLastError());
    throw std::runtime_error(
        std::string("built for other CUDA architectures than that of ") + device.name +
        ": set TALUS_CUDA_ARCHITECTURES");
  }
  // Code of an older architecture does not wait for its predecessor by itself.
  can_chain_ = device.major >= 9 && code.ptxVersion >= 90;
  marked_ = make_event();
  side_ = make_queue();
  use(0);
}

inline OutputMemory CudaExecutor::map_output(float* host, std::size_t size)
{
  auto& outputs = slot().outputs;
  outputs.emplace_back(host, size * sizeof(float));
  auto* mapped = static_cast<float*>(outputs.back().device());
  const bool fits = mapped && slot().direct_bytes + size * sizeof(float) <= kDirectBytes;
  if (fits) slot().direct_bytes += size * sizeof(float);
  return {mapped, fits};
}

inline bool CudaExecutor::copies_points(std::size_t capacity)
{
  return 3 * capacity * sizeof(float) > kReadBytes;
}

inline PointArrays CudaExecutor::point_arrays(std::size_t capacity)
{
  CudaSlot& s = slot();
  if (capacity != s.capacity)
  {
    s.capacity = 0;  // until all memory is there
    s.staged = {};
    s.staged = PinnedBuffer<std::uint32_t>(kStagedPoints + 4 * capacity);
    std::memset(s.staged.data(), 0, s.staged.size() * sizeof(std::uint32_t));
    allocate(s.points, copies_points(capacity) ? 4 * capacity : 0, 0.0f);
    s.capacity = capacity;
  }
  auto* p = reinterpret_cast<float*>(s.staged.data() + kStagedPoints);
  return {p, p + capacity, p + 2 * capacity, p + 3 * capacity};
}

inline kernels::PointsIn CudaExecutor::stage(
    const Frame& frame, const kernels::FrameContext& context, std::size_t capacity)
{
  slot().start = CudaSlot::Clock::now();
  const PointArrays to = point_arrays(capacity);
  std::memcpy(slot().staged.data(), &context, sizeof context);
  const float* const from[] = {frame.x_m, frame.y_m, frame.z_m, frame.time_s};
  float* const p = copies_points(capacity) ? slot().points.data() : to.x_m;
  const int arrays = frame.size == 0 ? 0 : context.has_times ? 4 : 3;
  std::array<CopyBlock, kMaxCopyBlocks> blocks;
  for (std::size_t a = 0; a < static_cast<std::size_t>(arrays); a++)
    blocks[a] = {to.x_m + a * capacity, from[a], frame.size * sizeof(float)};
  const auto send = [&](std::size_t a)
  {
    if (copies_points(capacity)) copy(p + a * capacity, to.x_m + a * capacity, frame.size);
  };
  copy_blocks(blocks.data(), arrays, std::ref(send));
  return {p, p + capacity, p + 2 * capacity, p + 3 * capacity};
}

/** Kernels read them in place: each value once, and only those of points that count. Recordings
 * know no frame, so that a channel that it does not have is there, and says nothing. */
inline ChannelArrays CudaExecutor::stage_channels(
    const Frame& frame, std::size_t channels, std::size_t capacity)
{
  CudaSlot& s = slot();
  if (s.channels.size() != channels * capacity)
  {
    s.channels = {};
    s.graphs = {};
    s.channels = PinnedBuffer<float>(channels * capacity);
  }
  ChannelArrays arrays{};
  for (std::size_t c = 0; c < channels; c++)
  {
    float* const to = s.channels.data() + c * capacity;
    arrays[c] = to;
    if (frame.channels[c])
      std::copy_n(frame.channels[c], frame.size, to);
    else
      std::fill_n(to, frame.size, kernels::kNan);
  }
  return arrays;
}

inline void CudaExecutor::fetch(Buffer<kernels::FrameContext>& frame)
{
  constexpr auto n = static_cast<int>(kContextWords);
  const std::uint32_t* const from = slot().staged.data();
  launch(
      loops::fetch, dim3(blocks(n, size_of(n))), dim3(size_of(n)), 0, n, from,
      reinterpret_cast<std::uint32_t*>(frame.data()));
  stage_end_++;
}

inline std::array<double, kStageCount> CudaExecutor::stage_ms() const
{
  std::array<double, kStageCount> ms{};
  const std::uint64_t* done = slot().stage_end_ns.data();
  for (std::size_t s = 0; s < ms.size(); s++)
    if (const int end_stage = end_of_stage_[s])
      ms[s] = static_cast<double>(done[end_stage] - done[end_stage - 1]) * 1e-6;
  return ms;
}

}  // namespace talus
