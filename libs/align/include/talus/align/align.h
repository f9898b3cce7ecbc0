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
  /** No move along what is unobservable; whole cells where the yaw stays. */
  site::MapShift shift;
  /** What is left of the estimate, since cells move as a whole [m]; 0: less than a tenth of one. */
  double rest_x_m = 0, rest_y_m = 0;
  /** False: it shares no measured ground with the others, and stays where it is. */
  bool overlaps = true;
  /** "x", "y", "z", "yaw" or "the direction at 30 degrees": what neither the ground nor what stands
   * on it tells, as along a corridor, or on a level floor. */
  std::vector<std::string> unobservable;
};

/** Brings the maps of several drives into the frame of the first: each in turn onto those that lie
 * already, the one with the most common ground first.
 *
 * Finds offsets up to 1.5 m and 7 degrees, and any in z. Of drives that began elsewhere, or a
 * quarter or half a turn apart, any, where what stands tells it, both have seen 40 % of that, and
 * the maps share ground as they lie. What differs between the maps, since it was built, parked or
 * taken away between the drives, has a bounded influence. Throws as site::read_site(). */
std::vector<Alignment> align_sites(
    const std::vector<std::string>& paths, const site::Progress& progress = site::Progress());

}  // namespace talus::align
