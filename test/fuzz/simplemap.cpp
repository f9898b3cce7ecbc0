#include <talus/io/trajectory.h>

#include "fuzz.h"

using namespace talus;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const fuzz::InputFile file(data, size, ".simplemap");
  fuzz::is_read([&] { io::Trajectory::load(file.path()); });
  return 0;
}
