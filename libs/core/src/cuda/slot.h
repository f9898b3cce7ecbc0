#pragma once
#include "backend.h"
#include "cuda/graph.h"
#include "kernels/1_points.h"

#include <chrono>
#include <vector>

namespace talus
{
/** A stream, and how others wait for it. */
struct WorkQueue
{
  Stream stream;
  Event reached;
  bool after_kernel = false;  //!< the next entry waits for a kernel, and for nothing else
};

inline WorkQueue make_queue()
{
  WorkQueue queue;
  queue.reached = make_event();
  queue.stream = make_stream();
  return queue;
}

/** `after` goes on when `before` is as far as it is now. */
inline void follow(WorkQueue& before, WorkQueue& after)
{
  TALUS_CUDA(cudaEventRecord(before.reached.get(), before.stream.get()));
  TALUS_CUDA(cudaStreamWaitEvent(after.stream.get(), before.reached.get(), 0));
  after.after_kernel = false;
}

/** What a frame on the device does not share with the one that is in flight beside it: how its
 * points come, how its layers and its report leave, and the recording that says so. */
struct CudaSlot
{
  using Clock = std::chrono::steady_clock;
  static constexpr int kMaxStageEnds = kStageCount + 1;

  CudaSlot() = default;
  /** Ready for use. */
  static CudaSlot make()
  {
    CudaSlot slot;
    slot.counters = PinnedBuffer<std::uint32_t>(kernels::kCounters);
    slot.stage_end_ns = PinnedBuffer<std::uint64_t>(kMaxStageEnds);
    slot.computed = make_event();
    slot.queue = make_queue();
    return slot;
  }

  std::vector<HostRegistration> outputs;
  std::size_t direct_bytes = 0;  //!< of outputs that kernels write into host memory
  // the points
  std::size_t capacity = 0;
  PinnedBuffer<std::uint32_t> staged;  //!< context, then x, y, z, time
  DeviceBuffer<float> points;
  // the report
  PinnedBuffer<std::uint32_t> counters;
  PinnedBuffer<std::uint64_t> stage_end_ns;
  Clock::time_point start;

  GraphExec graph;
  Event computed;  //!< all kernels are done; copies to the host may go on
  bool marks_computed = false;  //!< the graph says so itself
  bool in_flight = false;
  WorkQueue queue;  //!< the last member: what is on it ends before the memory goes
};

}  // namespace talus
