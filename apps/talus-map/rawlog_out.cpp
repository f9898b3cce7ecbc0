#include "rawlog_out.h"

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CFileInputStream.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <talus/io/packed_log.h>
#include <talus/io/atomic_file.h>
#include <talus/io/mrpt_error.h>
#include <talus/io/rawlog_reader.h>
#include <talus/mrpt/CObservationTraversability.h>

#include <filesystem>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
using mrpt::obs::CObservation;
using mrpt::serialization::CArchive;
using Snapshot = CObservationTraversability;

/** The snapshots in the order in which they were taken. */
class Snapshots
{
 public:
  explicit Snapshots(const std::string& path) : file_(path), archive_(file_) { advance(); }

  /** The one that belongs to this observation, or nullptr. */
  Snapshot::Ptr of(const CObservation& obs)
  {
    if (!next_ || obs.timestamp != next_->timestamp || obs.sensorLabel != label_) return nullptr;
    Snapshot::Ptr found = next_;
    advance();
    ++given_;
    return found;
  }

  std::size_t given() const { return given_; }

 private:
  void advance()
  {
    next_.reset();
    if (file_.getPosition() >= file_.getTotalBytesCount()) return;
    archive_ >> label_;
    next_ = Snapshot::Create();
    archive_ >> *next_;
  }

  mrpt::io::CFileInputStream file_;
  mrpt::serialization::CArchiveStreamBase<mrpt::io::CFileInputStream> archive_;
  std::string label_;  //!< of the scan
  Snapshot::Ptr next_;
  std::size_t given_ = 0;
};

bool is_snapshot(const mrpt::serialization::CSerializable::Ptr& object)
{
  return std::dynamic_pointer_cast<Snapshot>(object) != nullptr;
}

/** Of a sensory frame the copy with its snapshots. */
void write_frame(CArchive& out, const mrpt::obs::CSensoryFrame& frame, Snapshots& snapshots)
{
  mrpt::obs::CSensoryFrame copy;
  for (const auto& obs : frame)
  {
    if (is_snapshot(obs)) continue;
    copy.insert(obs);
    if (const auto snapshot = snapshots.of(*obs)) copy.insert(snapshot);
  }
  out << copy;
}

void write_object(
    CArchive& out, const mrpt::serialization::CSerializable::Ptr& object, Snapshots& snapshots)
{
  if (is_snapshot(object)) return;
  if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object))
    return write_frame(out, *frame, snapshots);
  out << *object;
  if (const auto obs = std::dynamic_pointer_cast<CObservation>(object))
    if (const auto snapshot = snapshots.of(*obs)) out << *snapshot;
}

fs::path without_endings(const std::string& log)
{
  const fs::path path(io::without_packing(log));
  return path.parent_path() / path.stem();
}
}  // namespace

RawlogOut::RawlogOut(const std::string& path, const std::string& log)
    : path_(path),
      log_(log),
      file_(path),
      snapshots_path_((file_.hidden_folder().path() / ".talus-snapshots").string())
{
  if (!snapshots_.open(snapshots_path_)) throw std::runtime_error(path_ + ": cannot be written");
}

RawlogOut::~RawlogOut()
{
  std::error_code ignored;
  snapshots_.close();
  fs::remove(snapshots_path_, ignored);
}

void RawlogOut::add(const LogMapper& mapper)
{
  Snapshot snapshot(mapper.map(), mapper.last_base());
  snapshot.timestamp = mapper.last_stamp();
  snapshot.T_base_sensor = mapper.last_sensor();
  try
  {
    auto archive = mrpt::serialization::archiveFrom(snapshots_);
    archive << mapper.last_label() << snapshot;
  }
  catch (const std::exception& e)
  {
    fail_to_write(io::reason_of(e));
  }
  ++snapshots_added_;
}

void RawlogOut::write()
{
  snapshots_.close();
  Snapshots snapshots(snapshots_path_);
  io::RawlogStream in(log_);
  mrpt::io::CFileGZOutputStream out;
  if (!out.open(file_.temporary_path())) throw std::runtime_error(path_ + ": cannot be written");
  auto to = mrpt::serialization::archiveFrom(out);
  while (const auto object = in.next()) try
    {
      write_object(to, object, snapshots);
    }
    catch (const std::exception& e)
    {
      fail_to_write(io::reason_of(e));
    }
  out.close();
  if (snapshots.given() != snapshots_added_) fail_to_write("snapshots are missing");
  io::require_complete_packed(file_.temporary_path(), path_);
}

void RawlogOut::fail_to_write(const std::string& reason) const
{
  throw std::runtime_error(
      path_ + ": could not be written (" + reason + "); is the disk full? Free some space there");
}

std::string RawlogOut::externals() const
{
  const std::string folder = without_endings(log_).string() + "_Images";
  std::error_code ignored;
  return fs::is_directory(folder, ignored) && folder != externals_of_copy() ? folder : "";
}

std::string RawlogOut::externals_of_copy() const
{
  return without_endings(path_).string() + "_Images";
}

}  // namespace talus::app
