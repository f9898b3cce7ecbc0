#pragma once
#include "cuda/memory.h"

#include <type_traits>

namespace talus
{
struct DestroyStream
{
  /** Waits, since the memory of its work may be freed next. */
  void operator()(cudaStream_t s) const
  {
    static_cast<void>(cudaStreamSynchronize(s));
    static_cast<void>(cudaStreamDestroy(s));
  }
};
struct DestroyEvent
{
  void operator()(cudaEvent_t e) const { static_cast<void>(cudaEventDestroy(e)); }
};
struct DestroyGraph
{
  void operator()(cudaGraph_t g) const { static_cast<void>(cudaGraphDestroy(g)); }
};
struct DestroyGraphExec
{
  void operator()(cudaGraphExec_t g) const { static_cast<void>(cudaGraphExecDestroy(g)); }
};

using Stream = std::unique_ptr<std::remove_pointer_t<cudaStream_t>, DestroyStream>;
using Event = std::unique_ptr<std::remove_pointer_t<cudaEvent_t>, DestroyEvent>;
using Graph = std::unique_ptr<std::remove_pointer_t<cudaGraph_t>, DestroyGraph>;
using GraphExec = std::unique_ptr<std::remove_pointer_t<cudaGraphExec_t>, DestroyGraphExec>;

/** A stream that does not wait for the default stream. */
inline Stream make_stream()
{
  cudaStream_t s = nullptr;
  TALUS_CUDA(cudaStreamCreateWithFlags(&s, cudaStreamNonBlocking));
  return Stream(s);
}

/** An event that orders, without time. */
inline Event make_event()
{
  cudaEvent_t e = nullptr;
  TALUS_CUDA(cudaEventCreateWithFlags(&e, cudaEventDisableTiming));
  return Event(e);
}

/** Records the work that `body` puts on the stream instead of running it. */
template <class Body>
Graph capture(const Stream& stream, const Body& body)
{
  cudaGraph_t graph = nullptr;
  TALUS_CUDA(cudaStreamBeginCapture(stream.get(), cudaStreamCaptureModeThreadLocal));
  try
  {
    body();
  }
  catch (...)
  {
    static_cast<void>(cudaStreamEndCapture(stream.get(), &graph));
    Graph discarded(graph);
    static_cast<void>(cudaGetLastError());
    throw;
  }
  TALUS_CUDA(cudaStreamEndCapture(stream.get(), &graph));
  return Graph(graph);
}

inline GraphExec instantiate(const Graph& graph)
{
  cudaGraphExec_t exec = nullptr;
  TALUS_CUDA(cudaGraphInstantiate(&exec, graph.get(), 0));
  return GraphExec(exec);
}

}  // namespace talus
