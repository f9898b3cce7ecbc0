#pragma once
#include "kernels/group.h"
#include "kernels/map.h"
#include "kernels/overhang.h"

namespace talus::kernels
{
// Stage 5 (III-B.2): a cell is cleared down to its ground if all rays that went on behind it passed
// below its surface and no point of this frame supports it. Stage 1 has turned the hits of each
// ring into the lowest ray that passed it, so that each cell is a look-up. The same table bounds
// unseen ground from above. Neighbours count in both directions: a cell beside what is hit in this
// frame waits, and one amid cells that were left leaves with them.

struct SeenThrough
{
  /** Of the lowest rays of its directions the highest slope, as an ordered integer. */
  std::int32_t highest = -kNoRay;
  std::int32_t unobstructed = 1;  //!< nothing was hit between the sensor and the cell
};

TALUS_HD void add_ray(
    SeenThrough& seen, const RayFootprint& g, int which, const Config& k, const std::int32_t* rays)
{
  const int bin = g.bin(which);
  const bool wanted = bin <= g.last_bin;
  const int column = select(wanted, wrap_bin(bin, bin_count(k)), 0);
  const std::int32_t hit = rays[g.row + column], anywhere = rays[column];
  seen.unobstructed = select(wanted & (hit != anywhere), 0, seen.unobstructed);
  seen.highest = max_of(seen.highest, select(wanted & (hit != kNoRay), hit, -kNoRay));
}

/** Counts one frame with or without a hit; true when the object is gone, after `frames`. */
TALUS_HD bool count_frame(Cell& c, bool hit, int frames)
{
  if (hit)
    c.frames_against = 0;
  else if (overhangs(c.stay_frames))
    c.stay_frames--;
  else
    c.frames_against++;
  if (c.frames_against < frames) return false;
  c.frames_against = 0;
  return true;
}

/** Removes the object from a cell, and ground above `limit`. */
TALUS_HD void clear(Cell& c, std::uint8_t& surface_class, float limit)
{
  note_object_left(c);
  if (surface_class == kObject || c.ground_m > limit)
  {
    c.ground_m = c.ground_var_m2 = kNan;
    c.state = kUnknown;
    surface_class = kInfer;
  }
  remove_object(c);
}

struct FindPassingRays
{
  using Item = RayFootprint;
  using Result = SeenThrough;
  const Map& m;

  TALUS_HD RayFootprint item(int ix, int iy) const { return footprint_of(m.k, *m.frame, ix, iy); }
  /** No fewer than there are rays. Further ones change nothing. */
  TALUS_HD int rays(const RayFootprint& g) const { return g.max_rays(); }
  TALUS_HD void add(SeenThrough& seen, const RayFootprint& g, int which) const
  {
    add_ray(seen, g, which, m.k, m.rays);
  }
  TALUS_HD void put(int ix, int iy, const RayFootprint& g, const SeenThrough& seen) const
  {
    const int i = m.lines.at(ix, iy);
    m.free_above_m[i] = height_m(g, seen.highest);
    m.ends_m[i] = ends_m(g, seen.highest);
    const bool unobstructed = (seen.unobstructed != 0) & (seen.highest != -kNoRay);
    m.unobstructed[i] = static_cast<std::uint8_t>(select(unobstructed, 1, 0));
  }
  /** The rest, in frames that start a map. */
  TALUS_HD void put_lowest(int ix, int iy, const RayFootprint& g) const
  {
    std::int32_t lowest = kNoRay;
    for (int which = 0; which < g.rays(); which++)
      lowest = min_of(lowest, m.rays[g.row + wrap_bin(g.bin(which), bin_count(m.k))]);
    m.lowest_ray_m[m.lines.at(ix, iy)] = height_m(g, lowest);
  }

  TALUS_HD void operator()(int ix, int iy) const
  {
    const RayFootprint g = item(ix, iy);
    SeenThrough seen;
    for (int which = 0; which < g.rays(); which++) add(seen, g, which);
    put(ix, iy, g, seen);
    if (m.frame->starts_map != 0) put_lowest(ix, iy, g);
  }

 private:
  TALUS_HD float ends_m(const RayFootprint& g, std::int32_t ray) const
  {
    const float end_m = end_of_ray_m(ray);
    const float at_end_m = m.frame->sensor_z_m + float_from_ordered(ray) * end_m;
    const float on_m = max_of(end_m - g.chebyshev_m, 0.0f);
    const float up_m = min_of(gentle_fall_m(on_m), kEndsRise_m);
    return select(abs_of(ray) != kNoRay, at_end_m + up_m, kInfinity);
  }
  /** The height where a ray is highest inside a cell: of a higher slope it is never lower. */
  TALUS_HD float height_m(const RayFootprint& g, std::int32_t ordered_slope) const
  {
    const float slope = float_from_ordered(ordered_slope), half_m = 0.5f * m.k.resolution_m;
    const float where_m = g.chebyshev_m + select(slope < 0.0f, -half_m, half_m);
    return select(
        abs_of(ordered_slope) != kNoRay, m.frame->sensor_z_m + slope * where_m, kInfinity);
  }
};

struct CleanUpCell
{
  const Map& m;

  TALUS_HD bool applies(int ix, int iy, int i) const
  {
    const int at = m.lines.at(ix, iy);
    const bool any = passed(at), fades = m.cell.recent_hits[i] > 0;
    return (any & (m.cell.state[i] != kUnknown) & (stands_above(at, i) | fades)) |
           appeared_after_robot(i);
  }

  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    if (needs_inspection(ix, iy, i)) inspect(ix, iy, i, SerialGroup{});
    finish(ix, iy, i);
  }

  /** Whether inspect() must come before finish(): the object may overhang. */
  TALUS_HD bool needs_inspection(int ix, int iy, int i) const
  {
    const int at = m.lines.at(ix, iy);
    return passed(at) && m.cell.state[i] != kUnknown && stands_above(at, i) &&
           (overhangs(m.cell.stay_frames[i]) || m.cell.is(kHitHighUp, i));
  }

  /** What is high up hangs, and is removed, if rays pass below it as high as the robot. Rays below
   * an overhang do not prove that it is gone. Rays that go on where it was hit do. */
  template <class Group>
  TALUS_HD void inspect(int ix, int iy, int i, const Group& group) const
  {
    const Config& k = m.k;
    const float top_m = top(i), hit_m = m.top_hit_m[i], limit_m = limit(m.lines.at(ix, iy));
    const bool hit = hit_m > limit_m;
    const OverhangRays<Group> overhang{m, footprint_of(k, *m.frame, ix, iy), group};
    const bool hangs = m.cell.is(kHitHighUp, i) && passed_below(overhang, i);
    if (hangs && group.rank() == 0)
    {
      Cell c = m.cell.load(i);
      remove_object(c);
      c.flags |= kPassedBelow;
      m.cell.store(i, c);
    }
    if (hangs || !overhangs(m.cell.stay_frames[i])) return;
    Extent extent{m.cell.overhang_below[i], m.cell.overhang_above[i]};
    if (hit)
    {
      extent = learn(extent, overhang, top_m, hit_m, limit_m);
      if (group.rank() != 0) return;
      m.cell.overhang_below[i] = static_cast<std::uint8_t>(extent.below);
      m.cell.overhang_above[i] = static_cast<std::uint8_t>(extent.above);
      return;
    }
    const float low_m = max_of(top_m - overhang_m(extent.below) + k.cleanup_margin_m, limit_m);
    const float high_m = top_m + overhang_m(extent.above) - k.cleanup_margin_m;
    const SlopeBins inside = overhang.between(low_m, high_m);
    const bool thin = inside.none();
    const bool went = overhang.went_on(thin ? overhang.around(top_m) : inside, thin);
    const bool gone = went || leaves_with_others(ix, iy);
    if (gone && group.rank() == 0) m.cell.stay_frames[i] = 0;
  }

  TALUS_HD void finish(int ix, int iy, int i) const
  {
    const int at = m.lines.at(ix, iy);
    Cell c = m.cell.load(i);
    const bool follows = appeared_after_robot(i), seen = passed(at);
    const bool stands = seen && stands_above(at, i);
    const float hit_m = m.top_hit_m[i], limit_m = select(stands, limit(at), kInfinity);
    const bool faded = seen && c.recent_hits > 0;  // rays passed
    if (faded) c.recent_hits--;
    if (stands && on(kRayBelowGround, m.k) && is_undercut(ix, iy, i)) m.surface_class[i] = kObject;
    // Hits below the rays do not protect it: behind a box that moved away they are on its floor.
    const bool hit = hit_m > select(stands, limit_m, bare_up_to_m(c.ground_m, m.k));
    // A hit above it hangs.
    if (stands && hit && hit_m <= top(i) + m.k.cleanup_margin_m) add_hit(c);
    if (follows && !hit) c.stay_frames = 0;
    const int frames = stands ? m.k.cleanup_frames : kFollowerLeaves_frames;
    const bool waits = stands && !hit && is_rim(i, limit_m);
    const bool left = (stands || follows) && !waits && count_frame(c, hit, frames);
    if (left) clear(c, m.surface_class[i], limit_m);
    if (stands || faded || follows) m.cell.store(i, c);
  }

 private:
  TALUS_HD bool passed(int at) const { return m.free_above_m[at] < kInfinity; }
  /** Whether rays passed below what is high up, as high as the robot. */
  template <class Group>
  TALUS_HD bool passed_below(const OverhangRays<Group>& rays, int i) const
  {
    const float margin_m = m.k.cleanup_margin_m;
    const SlopeBins gap =
        rays.between(m.cell.ground_m[i] + m.k.clearance_m - margin_m, top(i) - margin_m);
    bool any = false;
    for (int s = gap.first; s < gap.end && !any; s++) any = rays.went_on({s, s + 1}, false);
    return any;
  }
  /** Whether an object stands where the robot drove: it moves. */
  TALUS_HD bool appeared_after_robot(int i) const
  {
    const float bare_m = bare_up_to_m(m.cell.ground_m[i], m.k);
    return m.cell.is(kRobotWasThere, i) & (m.cell.elevation_m[i] > bare_m);
  }
  /** Whether a cell is the rim of an object beside it: rays pass its empty part, but a cell close
   * by was hit above them, and nothing shows its own floor. */
  TALUS_HD bool is_rim(int i, float limit_m) const
  {
    const bool presumed = m.cell.state[i] == kPresumed && !is_known(m.cell.elevation_m[i]);
    if (!on(kAsAWhole, m.k) || presumed || m.top_hit_m[i] > -kInfinity) return false;
    const int n = m.k.cells, y = floor_div(i, n), x = i - y * n;
    bool beside = false;
    for (int dy = -kRim_cells; dy <= kRim_cells; dy++)
      for (int dx = -kRim_cells; dx <= kRim_cells; dx++)
        beside |= m.top_hit_m[wrap_bin(y + dy, n) * n + wrap_bin(x + dx, n)] > limit_m;
    return beside;
  }
  TALUS_HD float top(int i) const
  {
    const float elevation = m.cell.elevation_m[i], ground = m.cell.ground_m[i];
    return select(is_known(elevation), elevation, ground);
  }
  TALUS_HD float limit(int at) const { return m.free_above_m[at] + m.k.cleanup_margin_m; }
  TALUS_HD bool stands_above(int at, int i) const
  {
    const int state = m.cell.state[i];
    const bool kept = (state == kMeasured) | (state == kPresumed);
    return (top(i) > limit(at)) & (is_known(m.cell.elevation_m[i]) | kept);
  }

  TALUS_HD bool is_undercut(int ix, int iy, int i) const
  {
    const float ground_m = m.cell.ground_m[i];
    const bool measured = m.cell.state[i] == kMeasured && m.surface_class[i] == kKeep;
    if (!measured || !(ground_m > limit(m.lines.at(ix, iy)))) return false;
    const float x_m = (static_cast<float>(ix) + 0.5f) * m.k.resolution_m;
    const float y_m = (static_cast<float>(iy) + 0.5f) * m.k.resolution_m;
    const FrameContext& f = *m.frame;
    const bool ahead = abs_of(x_m - f.sensor_x_m) >= abs_of(y_m - f.sensor_y_m);
    const auto over = [&](int d)
    {
      const int x = ix + (ahead ? 0 : d), y = iy + (ahead ? d : 0);
      return m.has(x, y) && passes_over(limit(m.lines.at(x, y)), ground_m);
    };
    return !on_both_sides(over);
  }

  TALUS_HD bool leaves_with_others(int ix, int iy) const
  {
    if (!on(kAsAWhole, m.k)) return false;
    const int px = m.pairs.pair_at(ix, m.frame->odd_x), r = kLeavesTogether_pairs;
    const int py = m.pairs.pair_at(iy, m.frame->odd_y), last = m.pairs.side - 1;
    int left = 0, stands = 0;
    for (int y = max_of(py - r, 0); y <= min_of(py + r, last); y++)
      for (int x = max_of(px - r, 0); x <= min_of(px + r, last); x++)
      {
        const auto presence = static_cast<int>(m.pair_presence[m.pairs.at(x, y)]);
        left += select(presence == kLeft, 1, 0);
        stands += select(presence == kStands, 1, 0);
      }
    return left > stands;
  }
  /** Lengths of an overhang from the top of the cell [kOverhangUnit_m]. */
  struct Extent
  {
    int below, above;
  };
  /** Lengthens the overhang by the hits of this frame, down to `limit_m` where rays passed. If the
   * hit is the new top, the length above the old one is void. */
  template <class Group>
  TALUS_HD Extent learn(
      const Extent& before, const OverhangRays<Group>& overhang, float top_m, float hit_m,
      float limit_m) const
  {
    const float low_m = min_of(hit_m, overhang.end_of_hits(hit_m, -1));
    const float high_m = max_of(hit_m, overhang.end_of_hits(hit_m, 1));
    const bool at_top = hit_m >= top_m - m.k.cleanup_margin_m;
    return {
        max_of(before.below, overhang_units(top_m - max_of(low_m, limit_m))),
        max_of(select(at_top, 0, before.above), overhang_units(high_m - top_m))};
  }
};

}  // namespace talus::kernels
