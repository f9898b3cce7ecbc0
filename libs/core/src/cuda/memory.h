#pragma once
#include <cuda_runtime.h>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

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

template <class T>
class DeviceBuffer
{
 public:
  DeviceBuffer() = default;
  explicit DeviceBuffer(std::size_t size) : size_(size)
  {
    void* p = nullptr;
    if (size) TALUS_CUDA(cudaMalloc(&p, size * sizeof(T)));
    data_.reset(static_cast<T*>(p));
  }
  T* data() const { return data_.get(); }
  std::size_t size() const { return size_; }

 private:
  struct Free
  {
    void operator()(T* p) const { static_cast<void>(cudaFree(p)); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

/** Host memory that the device reaches under the same address. */
template <class T>
class PinnedBuffer
{
 public:
  PinnedBuffer() = default;
  explicit PinnedBuffer(std::size_t size) : size_(size)
  {
    void* p = nullptr;
    if (size) TALUS_CUDA(cudaHostAlloc(&p, size * sizeof(T), cudaHostAllocMapped));
    data_.reset(static_cast<T*>(p));
  }
  T* data() const { return data_.get(); }
  std::size_t size() const { return size_; }

 private:
  struct Free
  {
    void operator()(T* p) const { static_cast<void>(cudaFreeHost(p)); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

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
  /** The device's address, or null. */
  void* device() const { return device_; }

 private:
  struct Unregister
  {
    void operator()(void* p) const { static_cast<void>(cudaHostUnregister(p)); }
  };
  std::unique_ptr<void, Unregister> memory_;
  void* device_ = nullptr;
};

}  // namespace talus
