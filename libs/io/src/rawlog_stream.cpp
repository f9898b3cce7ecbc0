#include <talus/io/rawlog_reader.h>

#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/obs/registerAllClasses.h>
#include <talus/input_file.h>
#include <talus/io/mrpt_error.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>

#include "archive.h"

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

std::string how_to_import(const std::string& path)
{
  return "Of scans or a bag of another program 'talus-import " + path +
         " --output LOG.rawlog' makes a log";
}

/** Of a log that can be read. */
const std::string& readable(const std::string& path)
{
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw std::runtime_error(
        path + ": is a directory, not a rawlog. Name the file inside it. " + how_to_import(path) +
        ".");
  require_readable_file(path, "rawlog");
  return path;
}
}  // namespace

struct RawlogStream::Impl
{
  explicit Impl(const std::string& p) : path(readable(p)), file(p), archive(file) {}

  /** Where not a single object could be read. */
  std::string else_import() const { return object_begin ? "" : ". " + how_to_import(path); }

  std::string path;
  std::uint64_t object_begin = 0;
  PackedFile file;
  PackedArchive archive;
  std::optional<KeyFrames> key_frames;  //!< of a simplemap that is being read
};

RawlogStream::RawlogStream(const std::string& path) : impl_(std::make_unique<Impl>(path))
{
  // Point clouds live in mrpt-maps: a program that calls nothing else of it may not have it loaded.
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();
  if (impl_->file.at_end())
    throw std::runtime_error(path + ": holds no data once unpacked. Record it again.");
}
RawlogStream::~RawlogStream() = default;

mrpt::serialization::CSerializable::Ptr RawlogStream::next()
{
  auto& key_frames = impl_->key_frames;
  const bool has_more = key_frames && !key_frames->at_end();
  impl_->object_begin = impl_->file.position();
  if (!has_more && impl_->file.at_end()) return nullptr;
  try
  {
    auto object = has_more ? nullptr : impl_->archive.next_object(key_frames);
    if (key_frames && !key_frames->at_end())
    {
      impl_->object_begin = impl_->file.position();
      object = key_frames->next();
    }
    if (object && !lacks_an_observation(*object)) return object;
  }
  catch (const std::bad_alloc&)
  {
    verified_size(impl_->path);  // packed data that is damaged says so itself
    fail(
        "needs more memory than there is. Most likely the log is damaged there" +
        impl_->else_import());
  }
  catch (const BadKeyFrame& e)
  {
    fail(e.what());
  }
  catch (const std::exception& e)
  {
    const std::uint64_t size = verified_size(impl_->path);
    const std::string reason = reason_of(e);
    if (reason.find("unknown serialization version") != std::string::npos)
      fail(
          "was written by a newer MRPT than this program has (" + reason +
          "), or is damaged. Read it where that version is installed");
    const bool at_end = impl_->file.position() >= size;
    if (impl_->object_begin == 0 && !at_end)
      throw std::runtime_error(
          impl_->path + ": not a rawlog, nothing of MRPT begins at byte 0 (" + reason +
          "). Pass a .rawlog file; if its classes come from a plugin, load the plugin" +
          impl_->else_import() + ".");
    if (at_end)
      fail(
          "runs past the end of the file at byte " + std::to_string(size) +
          ": the log is cut short or damaged. Copy it again, or keep what is whole with "
          "rawlog-edit --cut" +
          impl_->else_import());
    fail(
        "cannot be read (" + reason +
        "). The log is damaged there, or its class comes from a newer MRPT or a plugin that is not "
        "loaded");
  }
  if (key_frames && key_frames->count() == 0) fail("is a simplemap without key frames");
  fail("is a null object, or holds one. The log is damaged there");
}

void RawlogStream::fail(const std::string& what) const
{
  throw std::runtime_error(
      impl_->path + ": the object at byte " + std::to_string(impl_->object_begin) + " " + what +
      ".");
}

double RawlogStream::progress() const { return impl_->file.progress(); }

}  // namespace talus::io
