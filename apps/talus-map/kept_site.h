#pragma once
#include "options.h"

#include <mrpt/obs/CObservation.h>
#include <talus/elevation_mapper.h>
#include <talus/io/summary_json.h>
#include <talus/site/gps_origin.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>
#include <talus/site/site_mapper.h>

#include <mrpt/poses/CPose3D.h>

#include <string>
#include <vector>

namespace talus::app
{
/** The site map of a log: all that its drive saw, and what was known before with --resume. */
class KeptSite
{
 public:
  /** Reads what is resumed. `parameters`: of the map. `folder`: for tiles that find no room in
   * memory. Throws std::runtime_error that names the file. */
  KeptSite(const Options& options, const Parameters& parameters, const std::string& folder);

  /** As ElevationMapper::update(). */
  FrameReport update(ElevationMapper& map, const Frame& frame);
  /** Whether it is one of a satellite receiver; then its fix counts, where there is one. */
  bool take_fix(
      const mrpt::obs::CObservation& obs, const std::optional<mrpt::poses::CPose3D>& T_map_base);

  /** After the last frame: what the window holds is kept, and where on Earth it is. Warnings go
   * where the run keeps them. `is_driven`: whether a robot drove along the poses. */
  void finish(const ElevationMapper& map, io::RunSummary& run, bool is_driven);
  /** Where on Earth; with fixes of a satellite receiver from finish() on. */
  const std::optional<site::GeoOrigin>& origin() const { return site_.origin; }
  /** Writes site.tif, site_island_1.tif, site_floor_1.tif ..., and a picture of each, into a
   * folder, titled by `name`; with --traffic also traffic.tif, traffic_floor_1.tif and so on.
   * Throws std::runtime_error naming the file. */
  void write(const std::string& folder, const std::string& name, const site::Progress& progress);

 private:
  void resume(const std::string& path, const std::vector<Channel>& channels);
  void warn_of_islands();
  void place(const site::GeoOrigin& origin);
  io::SiteSummary summary();

  site::Site site_;
  site::Far far_;
  std::optional<site::SiteMapper> mapper_;  //!< begins when what is resumed has been read
  std::vector<site::GpsFix> fixes_;
  std::vector<std::string> warnings_;
  int islands_ = 0;  //!< beside the first of each floor
};

/** The place that --origin names. Throws std::invalid_argument that says what is wrong with it. */
site::GeoOrigin origin_from_text(const std::string& text);

}  // namespace talus::app
