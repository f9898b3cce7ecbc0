#pragma once
#include "backend.h"
#include "cuda/resources.h"
#include "kernels/1_points.h"

#include <chrono>
#include <vector>

namespace talus
{
/** A stream, and the event on which others wait. */
struct WorkQueue
{
  Stream stream;
  Event reached;
  bool after_kernel = false;  //!< the next entry waits for one kernel only
};

inline WorkQueue make_queue()
{
  WorkQueue queue;
  queue.reached = make_event();
  queue.stream = make_stream();
  return queue;
}

/** `after` waits for the work that `before` has now. */
inline void follow(WorkQueue& before, WorkQueue& after)
{
  TALUS_CUDA(cudaEventRecord(before.reached.get(), before.stream.get()));
  TALUS_CUDA(cudaStreamWaitEvent(after.stream.get(), before.reached.get(), 0));
  after.after_kernel = false;
}

/** A frame's own memory on the device: its points, layers, report and recording. */
struct CudaSlot
{
  using Clock = std::chrono::steady_clock;
  static constexpr int kMaxStageEnds = kStageCount + 1;

  CudaSlot() = default;
  static CudaSlot make()
  {
    CudaSlot slot;
    slot.counts = PinnedBuffer<kernels::FrameCounts>(1);
    slot.stage_end_ns = PinnedBuffer<std::uint64_t>(kMaxStageEnds);
    slot.computed = make_event();
    slot.queue = make_queue();
    return slot;
  }

  std::vector<HostRegistration> outputs;
  std::size_t direct_bytes = 0;  //!< outputs that kernels write into host memory
  std::size_t capacity = 0;
  PinnedBuffer<std::uint32_t> staged;  //!< context, then x, y, z, time
  DeviceBuffer<float> points;
  PinnedBuffer<float> channels;  //!< values of the points, channel after channel
  PinnedBuffer<kernels::FrameCounts> counts;
  PinnedBuffer<std::uint64_t> stage_end_ns;
  Clock::time_point start;

  std::array<GraphExec, 2> graphs;  //!< of a frame, and of the first one of a map
  Event computed;  //!< all kernels are done; copies to the host may follow
  bool marks_computed = false;  //!< the graph records the event itself
  bool in_flight = false;
  WorkQueue queue;  //!< last member: its work ends before the memory is freed
};

}  // namespace talus
