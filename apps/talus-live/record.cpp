#include "record.h"

#include "../common/log_name.h"

#include <stdexcept>

namespace talus::app
{
Record::Record(const std::string& log)
    : tum_(trajectory_beside(log)), scans_(log, {}), poses_(tum_, std::ios::binary)
{
  poses_ << "# t[s] x[m] y[m] z[m] qx qy qz qw of the base in the map\n";
}

void Record::add(const std::vector<io::Trajectory::Entry>& poses)
{
  for (const auto& pose : poses) poses_ << io::tum_line(pose);
}

void Record::close()
{
  scans_.close();
  poses_.close();
  if (!poses_) throw std::runtime_error(tum_ + ": cannot be written; is the disk full?");
}

}  // namespace talus::app
