#pragma once
#include <talus/site/map_shift.h>
#include <talus/site/site.h>
#include <talus/site/site_geotiff.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace talus::site
{
/** How two maps of one frame fit where both know the ground. Ground is compared where both have
 * measured it; what stands, where both have seen the cell and one shows something. */
struct MapFit
{
  /** Which two, counted from 0 as they were given. */
  std::size_t first = 0, second = 0;
  /** What both know. */
  double overlap_m2 = 0;
  /** What is compared of it. */
  double ground_m2 = 0, standing_m2 = 0;
  /** How far the ground of the second lies above that of the first, median [m]; NaN where none is
   * compared. */
  double offset_z_m = NAN;
  /** [0, 1] of what is compared; 0 where nothing is. Grounds disagree that differ by more than
   * their noise and 3 cm; what stands disagrees where the other map shows nothing within a cell. */
  double ground_disagrees = 0, standing_disagrees = 0;

  /** False where the two do not lie in one frame, or one of them is wrong. Drives of different days
   * fit: what was built, dug or parked is a small part of an overlap. */
  bool fits() const;
};

/** Of a floor of two sites of one resolution. Throws as TileStore. */
MapFit fit_of(Site& first, Site& second, int floor);

/** What several maps know of one cell; the order of the cells makes no difference to any bit.
 *
 * The ground is that of the best evidence: measured before filled from two sides before filled from
 * one. Among equals the newest counts, and with it all that lie within `step_m` of it: their mean
 * by information, which sums, as far as they agree: where they lie farther apart than their
 * variances allow, all of these grow by the same amount until they agree, and so does that of the
 * mean (the random effects of DerSimonian and Laird). What stands on the ground is that of the
 * newest map that has seen the cell, measured its ground or something on it: a box that this does
 * not show is gone. Scores and evidence are of that cell, too. Cells with the same bits are one
 * observation. */
SiteCell merge_cells(const SiteCell* cells, int count, double step_m);

/** How maps are fused. */
struct MergeOptions
{
  double step_m = 0.2;  //!< heights farther apart contradict each other
  int threads = 0;  //!< 0: all cores
  /** How each map is moved first, in the order of the paths; empty: not at all. */
  std::vector<MapShift> shifts{};
};

/** Fuses sites of one map frame, all their files, into an empty site, tile by tile, and their ways:
 * the files that are named become floor `floor`, other floors those of their numbers. The order of
 * the paths and the number of threads make no difference. Throws as parts_of_site(). Tells how the
 * maps fit that overlap: in each tile each with up to four of those given before it. */
std::vector<MapFit> merge_sites(
    const std::vector<std::string>& paths, Site& site, int floor, const MergeOptions& options = {},
    const Progress& progress = Progress());

}  // namespace talus::site
