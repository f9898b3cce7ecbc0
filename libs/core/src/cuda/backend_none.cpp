#include "backend.h"

#include <stdexcept>

namespace talus
{
std::unique_ptr<BackendInterface> make_cuda_backend(const MapConfig&)
{
  throw std::runtime_error("talus was built without CUDA");
}

}  // namespace talus
