#include <talus/io/rawlog_reader.h>

#include "packed_file.h"

#include <mrpt/io/lazy_load_path.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationStereoImages.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <talus/input_file.h>
#include <talus/io/mrpt_error.h>
#include <talus/io/packed_log.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/registerAllClasses.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

using mrpt::obs::CObservation;
namespace fs = std::filesystem;

namespace talus::io
{
namespace
{
/** Where the external files of a log lie. CRawlog::detectImagesDirectory() of MRPT 2.5 forgets the
 * slash before the names unless the log is in the current directory; where rawlog-edit has written
 * there all the same, its answer is taken. */
std::string externals_directory(const std::string& log)
{
  const fs::path path(log);
  const std::string stem = fs::path(without_packing(path.filename().string())).stem().string();
  std::error_code ignored;
  for (const auto& candidate : {stem + "_Images", stem + "_IMAGES", std::string("Images")})
    if (const auto folder = path.parent_path() / candidate; fs::is_directory(folder, ignored))
      return folder.string();
  auto by_mrpt = mrpt::obs::CRawlog::detectImagesDirectory(log);
  if (fs::is_directory(by_mrpt, ignored)) return by_mrpt;
  return (path.parent_path() / (stem + "_Images")).string();
}

/** The files that load() reads of an observation. */
std::vector<std::string> external_files(const CObservation& obs)
{
  std::vector<std::string> files;
  if (auto* points = dynamic_cast<const mrpt::obs::CObservationPointCloud*>(&obs);
      points && points->isExternallyStored())
    files.push_back(mrpt::io::lazy_load_absolute_path(points->getExternalStorageFile()));
  auto* depth = dynamic_cast<const mrpt::obs::CObservation3DRangeScan*>(&obs);
  if (depth && depth->points3D_isExternallyStored())
    files.push_back(depth->points3D_getExternalStorageFileAbsolutePath());
  if (depth && depth->rangeImage_isExternallyStored())
  {
    files.push_back(depth->rangeImage_getExternalStorageFileAbsolutePath(""));
    for (const auto& layer : depth->rangeImageOtherLayers)
      files.push_back(depth->rangeImage_getExternalStorageFileAbsolutePath(layer.first));
  }
  return files;
}

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

struct RawlogReader::Impl
{
  explicit Impl(const std::string& path) : stream(path), externals(externals_directory(path)) {}

  /** Reads on until an observation is pending or the log ends. */
  void fill();
  void load(const CObservation& obs);

  RawlogStream stream;
  std::string externals;  //!< directory of the externally stored data
  std::deque<CObservation::Ptr> pending;  //!< of the sensory frame read last
  std::string description;  //!< of the log
};

/** Pictures load themselves on first access: a log without its picture files can still be mapped.
 */
void RawlogReader::Impl::load(const CObservation& obs)
{
  if (dynamic_cast<const mrpt::obs::CObservationImage*>(&obs)) return;
  if (dynamic_cast<const mrpt::obs::CObservationStereoImages*>(&obs)) return;
  try
  {
    mrpt::io::setLazyLoadPathBase(externals);  // global in MRPT: another reader may have set it
    for (const auto& file : external_files(obs)) require_readable_file(file, "part of a log");
    obs.load();
  }
  catch (const std::exception& e)
  {
    stream.fail(
        "('" + obs.sensorLabel + "') has external data that cannot be loaded from " + externals +
        " (" + reason_of(e) + "). Put that directory beside the log");
  }
}

void RawlogReader::Impl::fill()
{
  while (pending.empty())
  {
    const auto object = stream.next();
    if (!object) return;
    if (auto obs = std::dynamic_pointer_cast<CObservation>(object);
        obs && obs->sensorLabel != kKeyFrames)
      pending.push_back(obs);
    else if (auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object))
      pending.assign(frame->begin(), frame->end());

    if (pending.empty()) continue;
    const auto comment = std::dynamic_pointer_cast<mrpt::obs::CObservationComment>(pending.front());
    if (!comment) continue;
    if (description.empty()) description = comment->text;
    pending.pop_front();
  }
}

RawlogReader::RawlogReader(const std::string& path) : impl_(std::make_unique<Impl>(path))
{
  impl_->fill();  // what is no rawlog shows at once
}
RawlogReader::~RawlogReader() = default;

const std::string& RawlogReader::description() const { return impl_->description; }

CObservation::Ptr RawlogReader::next()
{
  impl_->fill();
  if (impl_->pending.empty()) return nullptr;
  auto obs = impl_->pending.front();
  impl_->pending.pop_front();
  impl_->load(*obs);
  return obs;
}

std::uint64_t bytes_of_log(const std::string& path)
{
  std::error_code none;
  const std::uintmax_t own = fs::file_size(path, none);
  if (none) return 0;
  std::uint64_t bytes = own;
  if (own > 0 && PackedFile(path).is_packed()) bytes *= kMaxPerByte;
  for (fs::directory_iterator i(externals_directory(path), none), end; !none && i != end;
       i.increment(none))
  {
    std::error_code is_no_file;
    const std::uintmax_t size = fs::file_size(i->path(), is_no_file);
    if (!is_no_file) bytes += size;
  }
  return bytes;
}

double RawlogReader::progress() const { return impl_->stream.progress(); }

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
