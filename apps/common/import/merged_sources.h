#pragma once
#include <talus/import/scan_source.h>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace talus::import
{
/** The scans of several sources in the order of time; one scan of each is in memory. */
class MergedSources
{
 public:
  /** Opens all. Throws std::runtime_error that names the file and what is wrong, here and below. */
  MergedSources(const std::vector<std::string>& paths, const SourceOptions& options);

  /** False at the end. A label comes from one source at a time: what two sensors see must not get
   * mixed up. */
  bool next(ImportedScan& scan);

  /** 0..1. */
  double progress() const;

  /** Of the first source that has any; `path` gets which. */
  io::Trajectory poses(std::string& path);

  std::vector<std::string> remarks() const;
  std::vector<std::string> warnings() const;
  /** See ScanSource. */
  Pieces pieces() const
  {
    return sources_.size() == 1 ? sources_[0].scans->pieces() : Pieces::Scans;
  }
  bool wants(SourceOptions& options) const;

 private:
  struct Source
  {
    std::string path;
    std::unique_ptr<ScanSource> scans;
    ImportedScan pending;
    bool has_pending = false;
  };
  struct LastOfLabel
  {
    const Source* source = nullptr;
    double time_s = 0;
    std::set<const Source*> ended;  //!< sources that another took over from
  };

  void read(Source& source);
  void require_one_source(const Source& source);

  std::vector<Source> sources_;
  std::map<std::string, LastOfLabel> last_;
};

/** What was done about the poses of a log. */
struct WrittenPoses
{
  std::size_t count = 0;  //!< 0: there are none, nothing was written
  double length_m = 0;  //!< of the way through them
  double first_s = 0, last_s = 0;
  std::string source;  //!< file or folder that they come from
};

/** Writes the poses of a log, whose scans were all read, as TUM text: those of the file that the
 * options name, a TUM file with poses of the base as it is, else those that the sources have.
 * Throws std::runtime_error that names the file and what is wrong. */
WrittenPoses write_poses(
    const std::string& tum, const SourceOptions& options, MergedSources& sources);

}  // namespace talus::import
