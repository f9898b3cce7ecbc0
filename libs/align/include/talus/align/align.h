#pragma once
#include <talus/site/map_shift.h>
#include <talus/site/site_geotiff.h>

#include <string>
#include <vector>

namespace talus::align
{
/** What brings a map into the frame of another. */
struct Alignment
{
  /** No move along what is untold. */
  site::MapShift shift;
  /** False: it shares no measured ground with the others, and stays where it is. */
  bool overlaps = true;
  /** "x", "y", "z", "yaw" or "the direction at 30 degrees": what neither the ground nor what stands
   * on it tells, as along a corridor, or on a level floor. */
  std::vector<std::string> untold;
};

/** Brings the maps of several drives into the frame of the first: each in turn onto those that lie
 * already, the one with the most common ground first. Whole cells move where the yaw stays.
 *
 * Finds offsets up to 1.5 m and 7 degrees, also of drives that began a quarter or half a turn apart
 * at one position, and any in z. What differs between the maps, since it was built, parked or taken
 * away between the drives, has a bounded influence. Throws as site::read_site(). */
std::vector<Alignment> align_sites(
    const std::vector<std::string>& paths, const site::Progress& progress = site::Progress());

}  // namespace talus::align
