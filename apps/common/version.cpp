#include "run_app.h"

#include "commit.h"  // made by commit.cmake

namespace talus::app
{
std::string version_line(const std::string& command)
{
  const std::string commit = TALUS_COMMIT;
  return command + " " TALUS_VERSION " (" + (commit.empty() ? "" : "commit " + commit + ", ") +
         TALUS_BACKENDS + ")";
}

}  // namespace talus::app
