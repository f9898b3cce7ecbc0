#include "record.h"

#include "../common/log_name.h"

#include <filesystem>
#include <stdexcept>

namespace talus::app
{
namespace
{
constexpr const char* kHead = "# t[s] x[m] y[m] z[m] qx qy qz qw of the base in the map\n";

void require(const std::ostream& file, const std::string& path)
{
  if (!file) throw std::runtime_error(path + ": cannot be written; is the disk full?");
}
}  // namespace

Record::Record(const std::string& log)
    : log_(log),
      tum_(trajectory_beside(log)),
      scans_(log, {}),
      used_(tum_, std::ios::binary),
      heard_(heard_tum(), std::ios::binary)
{
  used_ << kHead;
  heard_ << kHead;
}

void Record::add(const import::ImportedScan& scan)
{
  scans_.write(scan);
  ++count_;
}

void Record::add(const io::Trajectory::Entry& used, const io::Trajectory::Entry& heard)
{
  used_ << io::tum_line(used);
  heard_ << io::tum_line(heard);
}

void Record::flush()
{
  scans_.flush();
  require(heard_.flush(), heard_tum());
}

void Record::take_poses()
{
  used_.close();
  std::filesystem::rename(other_tum(), tum_);
  used_.open(tum_, std::ios::binary | std::ios::app);
  require(used_, tum_);
}

void Record::close()
{
  scans_.close();
  used_.close();
  require(used_, tum_);
  heard_.close();
  for (const auto& path : {heard_tum(), other_tum()}) std::filesystem::remove(path);
}

}  // namespace talus::app
