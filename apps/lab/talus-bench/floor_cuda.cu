#include "floor.h"
#include "measure.h"

#include <cuda_runtime.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <string>

namespace talus::bench
{
namespace
{
constexpr int kKernels = 11, kRuns = 201;

__global__ void nothing() {}

void check(cudaError_t e)
{
  if (e != cudaSuccess) throw std::runtime_error(std::string("floor: ") + cudaGetErrorString(e));
}

cudaGraphExec_t record(
    cudaStream_t stream, void* device, void* host, std::size_t up, std::size_t down)
{
  cudaGraph_t graph;
  cudaGraphExec_t exec;
  check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal));
  check(cudaMemcpyAsync(device, host, up, cudaMemcpyHostToDevice, stream));
  for (int i = 0; i < kKernels; i++) nothing<<<132, 256, 0, stream>>>();
  check(cudaMemcpyAsync(host, device, down, cudaMemcpyDeviceToHost, stream));
  check(cudaStreamEndCapture(stream, &graph));
  check(cudaGraphInstantiate(&exec, graph, 0));
  check(cudaGraphDestroy(graph));
  return exec;
}
}  // namespace

std::optional<double> cuda_floor_s(std::size_t points, int cells, int layers)
{
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) return std::nullopt;
  const auto n = static_cast<std::size_t>(cells);
  const std::size_t up = points * 3 * sizeof(float);
  const std::size_t down = static_cast<std::size_t>(layers) * n * n * sizeof(float);
  void *device = nullptr, *host = nullptr;
  cudaStream_t stream;
  check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking));
  check(cudaMalloc(&device, std::max(up, down)));
  check(cudaHostAlloc(&host, std::max(up, down), cudaHostAllocDefault));
  std::memset(host, 0, std::max(up, down));
  cudaGraphExec_t exec = record(stream, device, host, up, down);
  std::vector<double> seconds;
  for (int i = 0; i < kRuns; i++)
  {
    const auto start = std::chrono::steady_clock::now();
    check(cudaGraphLaunch(exec, stream));
    check(cudaStreamSynchronize(stream));
    seconds.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  check(cudaGraphExecDestroy(exec));
  check(cudaFreeHost(host));
  check(cudaFree(device));
  check(cudaStreamDestroy(stream));
  return quantile(seconds, 0.5);
}

}  // namespace talus::bench
