#pragma once
#include "../common/settings.h"

#include <talus/elevation_mapper.h>
#include <talus/frame_gatherer.h>
#include <talus/import/scan_source.h>
#include <talus/io/layer_stack.h>
#include <talus/mrpt/observation_points.h>
#include <talus/site/site_mapper.h>

#include <mrpt/poses/CPose3D.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace talus::app
{
/** What tells that all results are there, see OutputFolder. */
constexpr const char* kSeal = "map.tif";

/** The map of a drive that goes on: the bits of talus-map with a log of the same scans and poses.
 */
class DriveMap
{
 public:
  /** `folder`: for tiles that find no room in memory. `resume`: a site.tif to go on with; empty:
   * none. Throws what ElevationMapper throws, and std::runtime_error that names the file. */
  DriveMap(
      const Settings& settings, double memory_mb, const std::string& folder,
      const std::string& resume);

  /** Maps a scan of a log, or gathers it where it is a part of one. What is wrong with it, then it
   * is left out; empty: nothing. Throws std::runtime_error where the site finds no room. */
  std::string add(const mrpt::obs::CObservation& scan, const io::Trajectory& poses);
  /** The same of one that is to be what a log gives back. */
  std::string add(const import::ImportedScan& scan, const io::Trajectory& poses);

  /** How many scans reached the map. */
  std::size_t frames() const { return frames_; }
  /** Why it is empty; "": some points were accepted, or none came. */
  std::string why_empty() const;
  const ElevationMapper& window() const { return map_; }
  /** From now on each frame makes these layers, and is shown as soon as it is in the window. */
  void set_output(const std::vector<Layer>& layers, std::function<void()> show)
  {
    map_.set_output_layers(layers);
    show_ = std::move(show);
  }
  /** From now on on threads as the settings say. */
  void run_on(const Settings& settings);
  const mrpt::poses::CPose3D& base() const { return T_map_base_; }  //!< in the last frame
  double stamp_s() const { return scan_.stamp_s; }  //!< of it
  site::Site& site() { return site_; }
  int floor() const { return mapper_.floor(); }

  /** A child process that writes what finish() would write now into a folder of results, whole or
   * not at all; this map goes on as it is. Its number; nothing where the site may find no room in
   * memory, of which a child cannot make any. */
  std::optional<int> start_save(const std::string& folder);

  /** Ends the drive and writes site.tif, map.tif and a picture of each into a folder. Throws
   * std::runtime_error naming the file, or why_empty(). */
  void finish(const std::string& folder);

 private:
  void map_scan(const Frame& scan);
  void write(const ElevationMapper& map, const std::string& folder);

  ElevationMapper map_;
  std::size_t memory_bytes_;
  site::Site site_;
  site::SiteMapper mapper_;
  FrameGatherer gatherer_;
  SensorNumbers sensors_;
  SensorPoints scan_;
  mrpt::poses::CPose3D T_map_base_;
  std::function<void()> show_ = [] {};
  std::size_t frames_ = 0;
  std::uint64_t points_ = 0, accepted_ = 0;
};

}  // namespace talus::app
