#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSerializable.h>
#include <talus/io/mrpt_error.h>
#include <talus/io/packed_log.h>
#include <talus/io/atomic_file.h>

#include <stdexcept>
#include <utility>

namespace talus::io
{
PackedLog::PackedLog(std::string path, const std::string& name)
    : path_(std::move(path)), name_(name.empty() ? path_ : name)
{
  if (!file_.open(path_, 1))
    throw std::runtime_error(
        name_ + ": cannot be written; is the disk full? Free some space there");
}

void PackedLog::write(const mrpt::serialization::CSerializable& object)
{
  try
  {
    auto archive = mrpt::serialization::archiveFrom(file_);
    archive << object;
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(
        name_ + ": could not be written (" + reason_of(e) +
        "); is the disk full? Free some space there");
  }
}

void PackedLog::close()
{
  file_.close();
  require_complete_packed(path_, name_);
}

}  // namespace talus::io
