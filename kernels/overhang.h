#pragma once
#include "kernels/group.h"
#include "kernels/map.h"

namespace talus::kernels
{
// How far the rays of a frame went, by direction and slope. Stage 4 asks whether an object stands
// on the one before it, stage 5 how far an overhang reaches, and whether it is gone.

constexpr int kMaxBinsPerCellBits = 3;  //!< near the sensor a cell uses eight bins

/** The rays through the middle half of a cell's angle that ended two or more rings behind it. */
struct RayFootprint
{
  std::int32_t first_bin = 0, last_bin = -1, stride = 1;
  std::int32_t row = 0;  //!< start of their ring in the table
  float chebyshev_m = 0;
  TALUS_HD int bin(int which) const { return first_bin + which * stride; }
  /** A bound of rays() without a division. */
  TALUS_HD int max_rays() const
  {
    return min_of(max_of(last_bin - first_bin + 1, 0), 1 << kMaxBinsPerCellBits);
  }
  TALUS_HD int rays() const
  {
    const int more = floor_div(last_bin - first_bin, stride, 1.0f / static_cast<float>(stride));
    return select(last_bin < first_bin, 0, more + 1);
  }
};

TALUS_HD RayFootprint footprint_of(const Config& k, const FrameContext& f, int ix, int iy)
{
  const float dx = (static_cast<float>(ix) + 0.5f) * k.resolution_m - f.sensor_x_m;
  const float dy = (static_cast<float>(iy) + 0.5f) * k.resolution_m - f.sensor_y_m;
  RayFootprint g;
  g.chebyshev_m = chebyshev(dx, dy);
  const float ring = g.chebyshev_m * k.inverse_resolution;
  const bool under_sensor = ring < kUnderSensor_rings;
  const int bins = bin_count(k), per_side = bins_per_side(k);
  const int behind = floor_to_int(ring) + kBehindCell_rings, last_ring = f.rings - 1;
  const bool none = under_sensor | (behind > last_ring);
  g.row = min_of(behind, last_ring) * bins;
  const float half_span = kFootprintHalfSpan * static_cast<float>(per_side) /
                          select(under_sensor, kUnderSensor_rings, ring);
  const float middle =
      direction_in_bins(select(under_sensor, 1.0f, dx), select(under_sensor, 0.0f, dy), per_side);
  g.first_bin = floor_to_int(middle - half_span);
  g.last_bin = select(none, g.first_bin - 1, floor_to_int(middle + half_span));
  g.stride = (max_of(g.last_bin - g.first_bin, 0) >> kMaxBinsPerCellBits) + 1;
  return g;
}

/** How far the rays of one direction went, for adjacent bins of slope; 0: no ray. */
struct alignas(16) SlopeEnds
{
  static constexpr int kSize = 4;
  std::int32_t ends[kSize];
};

/** The bins of slope [first, end). */
struct SlopeBins
{
  int first = 0, end = 0;
  TALUS_HD bool none() const { return first >= end; }
};

/** Questions to the rays of this frame about an overhang in one cell: how far it reaches, and
 * whether it is gone. A group shares the directions of the cell. */
template <class Group>
struct OverhangRays
{
  const Map& m;
  RayFootprint footprint;
  Group group;

  /** The bins of slope at which rays go through the cell between two heights. */
  TALUS_HD SlopeBins between(float low_m, float high_m) const
  {
    return {
        max_of(floor_to_int(bin_at(low_m)) + 1, 0),
        min_of(floor_to_int(bin_at(high_m)), kSlopeBins)};
  }
  /** The bin at which rays go through the cell at a height, and both next to it. */
  TALUS_HD SlopeBins around(float height_m) const
  {
    const int at = floor_to_int(bin_at(height_m));
    return at >= 1 && at + 1 < kSlopeBins ? SlopeBins{at - 1, at + 2} : SlopeBins{};
  }

  /** Whether rays of these bins, or of each, ended two rings behind the cell, and none before. */
  TALUS_HD bool went_on(const SlopeBins& bins, bool each) const
  {
    const int width = each ? 1 : max_of(bins.end - bins.first, 1);
    bool all = footprint.rays() > 0 && !bins.none();
    for (int first = bins.first; all && first < bins.end; first += width)
    {
      int worst = kNoneAimed;
      for (int which = group.rank(); which < footprint.rays(); which += group.size())
        worst = max_of(worst, static_cast<int>(aimed(bin(which), first, first + width)));
      all = group.max(worst) == kAllWentOn;
    }
    return all;
  }

  /** The end of the hits that go on down (`up` = -1) or up (1) from a height in the cell, with no
   * ray passing in between, in the direction where they go farthest. Hits up to two rings before
   * the cell and one behind it count, since an overhang is seldom one cell wide. */
  TALUS_HD float end_of_hits(float hit_m, int up) const
  {
    const int first = first_bin_of(hit_m, up), none = first - up;
    int farthest = none * up;
    for (int which = group.rank(); which < footprint.rays(); which += group.size())
      farthest = max_of(farthest, follow(bin(which), first, up) * up);
    return height_of(group.max(farthest) * up, none, hit_m);
  }

 private:
  enum Aimed
  {
    kNoneAimed,
    kAllWentOn,
    kEndedBefore
  };

  TALUS_HD SlopeEnds ends_at(int bin, int quad) const
  {
    const SlopeEnds* const quads = reinterpret_cast<const SlopeEnds*>(m.reach);
    return quads[bin * (kSlopeBins / SlopeEnds::kSize) + quad];
  }
  TALUS_HD float bin_at(float height_m) const
  {
    return slope_bin(ray_slope(height_m - m.frame->sensor_z_m, footprint.chebyshev_m));
  }
  TALUS_HD int bin(int which) const
  {
    return wrap_bin(footprint.first_bin + which * footprint.stride, bin_count(m.k));
  }

  TALUS_HD Aimed aimed(int bin, int first, int end) const
  {
    bool any = false, before = false;
    for (int quad = first / SlopeEnds::kSize; quad * SlopeEnds::kSize < end; quad++)
    {
      const SlopeEnds rays = ends_at(bin, quad);
      for (int s = 0; s < SlopeEnds::kSize; s++)
      {
        const int at = quad * SlopeEnds::kSize + s, ray = rays.ends[s];
        const bool is_ray = (at >= first) & (at < end) & (ray > 0);
        any |= is_ray;
        before |= is_ray & (ray < footprint.row);
      }
      if (before) return kEndedBefore;
    }
    return any ? kAllWentOn : kNoneAimed;
  }

  TALUS_HD int first_bin_of(float hit_m, int up) const
  {
    return floor_to_int(bin_at(hit_m)) + select(up > 0, 1, 0);
  }
  TALUS_HD float height_of(int last, int none, float hit_m) const
  {
    if (last == none) return hit_m;
    return m.frame->sensor_z_m + slope_of_bin(last) * footprint.chebyshev_m;
  }

  /** The last slope bin that was hit, from `first` on; the one before `first` if there is none. */
  TALUS_HD int follow(int bin, int first, int up) const
  {
    const int nearest = footprint.row - (kBehindCell_rings + kBeforeCell_rings) * bin_count(m.k);
    int last = first - up;
    bool more = first >= 0 && first < kSlopeBins;
    for (int quad = first / SlopeEnds::kSize;
         more && quad >= 0 && quad < kSlopeBins / SlopeEnds::kSize; quad += up)
    {
      const SlopeEnds rays = ends_at(bin, quad);
      for (int n = 0; n < SlopeEnds::kSize; n++)
      {
        const int s = up > 0 ? n : SlopeEnds::kSize - 1 - n, ray = rays.ends[s];
        const int at = quad * SlopeEnds::kSize + s;
        const bool is_ray = more & ((at - first) * up >= 0) & (ray > 0);
        const bool before = ray < nearest, behind = ray >= footprint.row;
        last = select(is_ray & !before & !behind, at, last);
        more &= !(is_ray & (before | behind));
      }
    }
    return last;
  }
};

}  // namespace talus::kernels
