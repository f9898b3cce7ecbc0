#pragma once
#include <talus/elevation_mapper.h>
#include <talus/site/site.h>

namespace talus::site
{
/** Keeps in a site what leaves the window of a map, and gives back what comes again. */
class SiteMapper
{
 public:
  /** `restores`: cells that come back are restored; else what was kept stays until the cell leaves
   * again. */
  explicit SiteMapper(Site& site, bool restores = true) : site_(site), restores_(restores) {}

  /** map.update(frame), and before it what leaves is kept, after it what came back restored. */
  FrameReport update(ElevationMapper& map, const Frame& frame);
  /** Keeps the cells of the window as they are: at the end of a drive, or between. */
  void keep_window(const ElevationMapper& map);
  /** Where the robot is. */
  int floor() const { return floor_; }

 private:
  Site& site_;
  bool restores_;
  int floor_ = 0;
};

}  // namespace talus::site
