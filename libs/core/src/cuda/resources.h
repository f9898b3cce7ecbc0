#pragma once
#include <cuda_runtime.h>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace talus
{
/** Throws with the call, the file and the line if a call of the CUDA runtime failed. */
inline void check_cuda(cudaError_t error, const char* call, const char* file, int line)
{
  if (error == cudaSuccess) return;
  static_cast<void>(cudaGetLastError());  // clears the error for the next call
  const char* slash = std::strrchr(file, '/');
  throw std::runtime_error(
      std::string("CUDA: ") + cudaGetErrorString(error) + " (" + cudaGetErrorName(error) + ") in " +
      call + ", " + (slash ? slash + 1 : file) + ":" + std::to_string(line));
}
#define TALUS_CUDA(call) ::talus::check_cuda((call), #call, __FILE__, __LINE__)

/** The device of a map. The thread that destroys the map may use another device. */
struct OwnDevice
{
  int number = 0;

  ~OwnDevice()
  {
    if (cudaSetDevice(number) != cudaSuccess) static_cast<void>(cudaGetLastError());
  }
};

/** Memory that `kAllocate` gives and `kFree` takes back. */
template <class T, cudaError_t (*kAllocate)(void**, std::size_t), cudaError_t (*kFree)(void*)>
class CudaMemory
{
 public:
  CudaMemory() = default;
  explicit CudaMemory(std::size_t size) : size_(size)
  {
    void* p = nullptr;
    if (size) TALUS_CUDA(kAllocate(&p, size * sizeof(T)));
    data_.reset(static_cast<T*>(p));
  }
  T* data() const { return data_.get(); }
  std::size_t size() const { return size_; }

 private:
  struct Free
  {
    void operator()(T* p) const { static_cast<void>(kFree(p)); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};
inline cudaError_t allocate_on_device(void** p, std::size_t bytes) { return cudaMalloc(p, bytes); }
inline cudaError_t allocate_pinned(void** p, std::size_t bytes)
{
  return cudaHostAlloc(p, bytes, cudaHostAllocMapped);
}
template <class T>
using DeviceBuffer = CudaMemory<T, allocate_on_device, cudaFree>;
/** Host memory that the device reaches under the same address. */
template <class T>
using PinnedBuffer = CudaMemory<T, allocate_pinned, cudaFreeHost>;

/** Makes host memory of others reachable for the device during its life. */
class HostRegistration
{
 public:
  /** If the system refuses, device() is null. */
  HostRegistration(void* memory, std::size_t bytes)
  {
    void* device = nullptr;
    if (cudaHostRegister(memory, bytes, cudaHostRegisterMapped) == cudaSuccess)
      memory_.reset(memory);
    if (memory_ && cudaHostGetDevicePointer(&device, memory, 0) == cudaSuccess) device_ = device;
    static_cast<void>(cudaGetLastError());
  }
  void* device() const { return device_; }

 private:
  struct Unregister
  {
    void operator()(void* p) const { static_cast<void>(cudaHostUnregister(p)); }
  };
  std::unique_ptr<void, Unregister> memory_;
  void* device_ = nullptr;
};

/** A handle of CUDA that `kDestroy` ends. */
template <class Handle, cudaError_t (*kDestroy)(Handle)>
struct Destroy
{
  void operator()(Handle handle) const { static_cast<void>(kDestroy(handle)); }
};
template <class Handle, cudaError_t (*kDestroy)(Handle)>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Destroy<Handle, kDestroy>>;

/** Waits, since the memory of its work may be freed next. */
inline cudaError_t finish_and_destroy(cudaStream_t s)
{
  static_cast<void>(cudaStreamSynchronize(s));
  return cudaStreamDestroy(s);
}
using Stream = Owned<cudaStream_t, finish_and_destroy>;
using Event = Owned<cudaEvent_t, cudaEventDestroy>;
using Graph = Owned<cudaGraph_t, cudaGraphDestroy>;
using GraphExec = Owned<cudaGraphExec_t, cudaGraphExecDestroy>;

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
