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

}  // namespace talus::import
