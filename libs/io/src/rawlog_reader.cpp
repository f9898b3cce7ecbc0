#include <talus/io/rawlog_reader.h>

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

#include "key_frames.h"
#include "packed_file.h"

#include <deque>
#include <filesystem>
#include <string>
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

}  // namespace talus::io
