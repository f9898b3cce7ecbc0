#include "rawlog_stream.h"

#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/obs/registerAllClasses.h>
#include <talus/io/mrpt_error.h>

#include <algorithm>
#include <new>
#include <stdexcept>

#include "input_file.h"

namespace talus::io
{
namespace
{
/** Whether a frame lacks one of its observations: MRPT reads such a frame, and it is of no use. */
bool lacks_an_observation(const mrpt::serialization::CSerializable& object)
{
  auto* frame = dynamic_cast<const mrpt::obs::CSensoryFrame*>(&object);
  return frame && std::any_of(frame->begin(), frame->end(), [](const auto& obs) { return !obs; });
}
}  // namespace

RawlogStream::RawlogStream(const std::string& path) : path_(path), archive_(file_)
{
  require_readable_file(path, "rawlog");
  size_ = verified_size(path);
  if (size_ == 0)
    throw std::runtime_error(path + ": holds no data once decompressed. Record it again.");

  // Point clouds live in mrpt-maps: a program that calls nothing else of it may not have it loaded.
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();

  std::string reason;
  if (!file_.open(path, reason))
    throw std::runtime_error(path + ": cannot be opened (" + reason + "). Check its permissions.");
}

mrpt::serialization::CSerializable::Ptr RawlogStream::next()
{
  object_begin_ = file_.getPosition();
  if (object_begin_ >= size_) return nullptr;
  try
  {
    mrpt::serialization::CSerializable::Ptr object;
    archive_ >> object;
    if (object && !lacks_an_observation(*object)) return object;
  }
  catch (const std::bad_alloc&)
  {
    fail("needs more memory than there is. Most likely the log is damaged there");
  }
  catch (const std::exception& e)
  {
    const bool at_end = file_.getPosition() >= size_;
    if (object_begin_ == 0 && !at_end)
      throw std::runtime_error(
          path_ + ": not a rawlog, nothing of MRPT begins at byte 0 (" + reason_of(e) +
          "). Pass a .rawlog file; if its classes come from a plugin, load the plugin.");
    if (at_end)
      fail(
          "runs past the end of the file at byte " + std::to_string(size_) +
          ": the log is cut short or damaged. Copy it again, or keep what is whole with "
          "rawlog-edit --cut");
    fail(
        "cannot be read (" + reason_of(e) +
        "). The log is damaged there, or its class comes from a plugin that is not loaded");
  }
  fail("is a null object, or holds one. The log is damaged there");
}

void RawlogStream::fail(const std::string& what) const
{
  throw std::runtime_error(
      path_ + ": the object at byte " + std::to_string(object_begin_) + " " + what + ".");
}

double RawlogStream::progress() const
{
  return static_cast<double>(file_.getPosition()) / static_cast<double>(size_);
}

}  // namespace talus::io
