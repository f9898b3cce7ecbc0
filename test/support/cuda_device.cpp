#include <gtest/gtest.h>
#include <talus/elevation_mapper.h>

#include <stdexcept>

// Linked into the executables that need a CUDA device: without one their cases are skipped, and say
// why.

namespace
{
class CudaDevice : public testing::Environment
{
  void SetUp() override
  {
    try
    {
      talus::ElevationMapper probe({}, talus::Backend::Cuda);
    }
    catch (const std::runtime_error& e)
    {
      GTEST_SKIP() << e.what();
    }
  }
};

const testing::Environment* const environment =
    testing::AddGlobalTestEnvironment(new CudaDevice);  // owned by GoogleTest
}  // namespace
