#pragma once
#include "../common/import/rawlog_writer.h"

#include <talus/io/trajectory.h>

#include <fstream>
#include <string>
#include <vector>

namespace talus::app
{
/** What reached the map, as a log of which talus-map makes the same map again. */
class Record
{
 public:
  /** The log; its poses go into a file beside it, whose ending is .tum. Throws std::runtime_error
   * naming the file, as all do. */
  explicit Record(const std::string& log);

  void add(const import::ImportedScan& scan) { scans_.write(scan); }
  void add(const std::vector<io::Trajectory::Entry>& poses);
  /** Ends both files. */
  void close();

 private:
  std::string tum_;
  import::RawlogWriter scans_;
  std::ofstream poses_;
};

}  // namespace talus::app
