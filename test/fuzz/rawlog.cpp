#include <talus/io/rawlog_reader.h>

#include "fuzz.h"

using namespace talus;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const fuzz::InputFile file(data, size, ".rawlog");
  fuzz::is_read(
      [&]
      {
        io::RawlogReader reader(file.path());
        while (reader.next()) fuzz::require(reader.progress() <= 1, "no more than all is read");
      });
  fuzz::is_read([&] { io::trajectory_from_rawlog(file.path()); });
  return 0;
}
