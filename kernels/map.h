#pragma once
#include "kernels/cell.h"
#include "kernels/channel.h"
#include "kernels/coarse_grid.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/lines.h"
#include "kernels/math.h"
#include "kernels/rays.h"
#include "kernels/rule_switches.h"

namespace talus::kernels
{
struct FrameCounts;
struct HeightPoint;
struct OffsetHistogram;
struct Track;

// The arrays of a map beside its cells, one line each: ARRAY(type, name, of what, value at first).
// Rules, buffers and allocation follow it. Rules that share an array say there what is in it.

#define TALUS_MAP_ARRAYS(ARRAY)                                                                    \
  ARRAY(Body, body, one, Body{})                                                                   \
  ARRAY(FrameContext, frame, one, FrameContext{})                                                  \
  ARRAY(Datum, datum, one, Datum{})                                                                \
  ARRAY(Datum, datum_before, device, Datum{}) /* of the frame before */                            \
  ARRAY(OffsetHistogram, offsets, one, OffsetHistogram{})                                          \
  ARRAY(FrameCounts, counts, one, FrameCounts{})                                                   \
  ARRAY(float, class_scores, class_scores, 0.0f) /* kClasses for each channel */                   \
  /* cells, by storage index */                                                                    \
  ARRAY(std::uint8_t, surface_class, cells, 0) /* a SurfaceClass */                                \
  ARRAY(float, top_hit_m, cells, 0.0f) /* highest point of this frame; -infinity: not hit */       \
  ARRAY(std::uint32_t, cell_count, cells, 0) /* points that the range of a cell has room for */    \
  ARRAY(std::uint32_t, kept_count, device_cells, 0) /* points that are in the range */             \
  ARRAY(std::uint32_t, cell_begin, cells, 0) /* of the range in `sorted`; their order is any */    \
  /* pairs of cells, by index in `pairs`; infinity: nothing is known */                            \
  ARRAY(float, pair_lowest_m, pairs, kInfinity) /* lowest measured ground */                       \
  ARRAY(float, pair_known_m, pairs, kInfinity) /* lowest ground, measured or inferred */           \
  ARRAY(float, pair_column_m, pairs, kInfinity) /* highest upright top; -infinity: none */         \
  ARRAY(float, pair_presence, pairs, kInfinity) /* a Presence */                                   \
  ARRAY(float, pair_eroded_m, pairs, kInfinity) /* lowest ground around; or an upright is near */  \
  ARRAY(float, pair_cone_m, pairs, kInfinity) /* the same, raised with distance */                 \
  ARRAY(float, pair_apart_m, pairs, kInfinity) /* above what is climbed from reached ground */     \
  ARRAY(float, pair_foot_m, pairs, kInfinity) /* lowest reached ground around */                   \
  ARRAY(float, pair_thing_m, pairs, kInfinity) /* highest top above a step; -infinity: none */     \
  ARRAY(float, pair_beside_m, pairs, kInfinity) /* the highest of those beside */                  \
  ARRAY(float, pair_limit_m, pairs, kInfinity) /* highest that ground can be there */              \
  ARRAY(std::int32_t, pair_reach, pairs, kOutsideWindow) /* a Reach */                             \
  /* cells, by index in `lines`. free_above_m: from here on rays proved a cell to be free in */    \
  /* this frame, and unseen ground lies lower; infinity: no ray. Of the lowest rays of its */      \
  /* directions the highest counts, so that a few reflections change nothing. ends_m: so high */   \
  /* its ground is at most if it goes on gently to where that ray ended. */                        \
  ARRAY(float, free_above_m, grid, kNan)                                                           \
  ARRAY(float, ends_m, grid, kNan)                                                                 \
  ARRAY(float, lowest_ray_m, grid, kNan) /* in frames that start a map; infinity: no ray */        \
  ARRAY(                                                                                           \
      std::uint8_t, unobstructed, grid,                                                            \
      0) /* 1: nothing was hit between the sensor and the cell */                                  \
  ARRAY(float, sample_m, samples, kNan) /* see TakeSample, then LayOutGround */                    \
  ARRAY(float, fall_m, grid, kNan) /* see estimate_fall(); set where stage 7 needs it */           \
  ARRAY(Surface, judged_surface, surfaces, (Surface{kNoHeight, 0})) /* see surface_at() */         \
  /* rays: the lowest slope of what was hit in a ring, then of what went at least that far, as */  \
  /* an ordered integer. reach: the greatest point_ray, that of the farthest ring */               \
  ARRAY(std::int32_t, rays, rays, kNoRay) /* [ring][bin] */                                        \
  ARRAY(float, lowest_slope, rays, -kInfinity) /* of rays that are not buried, where any is hit */ \
  ARRAY(std::int32_t, reach, slopes, 0) /* [bin][slope bin]; 0: no ray */                          \
  /* points of a frame */                                                                          \
  ARRAY(std::int32_t, point_ray, points, -1) /* index in `rays`, or -1: no direction */            \
  ARRAY(float, point_slope, points, 0.0f) /* slope of that ray */                                  \
  ARRAY(std::int32_t, point_reach, points, -1) /* index in `reach`, or -1 */                       \
  ARRAY(std::uint32_t, point_reject, points, 0) /* a RejectCode */                                 \
  ARRAY(std::uint32_t, point_rank, points, 0) /* among those of its cell, in any order */          \
  ARRAY(float, point_height_m, points, 0.0f) /* map frame */                                       \
  ARRAY(float, point_variance_m2, points, 0.0f)                                                    \
  ARRAY(HeightPoint, sorted, points, (HeightPoint{0, 0})) /* each cell has a range */              \
  ARRAY(std::int32_t, crowded, crowded, 0) /* cells that a group updates; see cells::Order */      \
  ARRAY(std::int32_t, point_surface, surface_points, kNoSurface) /* see Channel::at() */           \
  ARRAY(std::uint8_t, point_begins, surface_points, 0) /* first there: a bit for each channel */   \
  ARRAY(std::uint32_t, voxel_slot, voxel_points, 0)                                                \
  ARRAY(std::uint8_t, voxel_kept, voxel_points, 0)                                                 \
  ARRAY(std::uint64_t, voxel_key, voxels, kNoVoxel) /* at least twice the points */                \
  ARRAY(std::uint64_t, voxel_winner, voxels, kNoVoxel)                                             \
  ARRAY(std::int32_t, point_cell, points, -1) /* storage index, or -1: not in the map */           \
  /* of cores */                                                                                   \
  ARRAY(std::uint8_t, doubted, core_bins, 0) /* see SweepRays */                                   \
  ARRAY(float, information, core_grid, kNan) /* LineFusion of a cell */                            \
  ARRAY(float, weighted, core_grid, kNan)                                                          \
  ARRAY(float, lowest_m, core_grid, kNan)                                                          \
  ARRAY(std::uint16_t, fill_marks, core_grid, 0) /* FillMark; without kInferred nothing counts */  \
  ARRAY(std::uint8_t, passability, core_window, 0) /* window order, a row and a cell more */       \
  /* of devices */                                                                                 \
  ARRAY(std::uint64_t, cursor, device, 0) /* see ends_of() */                                      \
  ARRAY(std::int32_t, line_of_cell, device_grid, 0)                                                \
  ARRAY(Track, track, device_lines, Track{}) /* by line */                                         \
  ARRAY(std::uint32_t, marks, marks, 0) /* of samples, see LineMarks: by line */                   \
  ARRAY(std::uint32_t, axis_marks, axis_marks, 0) /* of the rows, then of the columns */

/** Destinations of the layers of a frame, window order; null: not wanted. */
struct Layers
{
  float *elevation, *ground, *variance, *state, *reached, *slope, *step, *roughness, *sparsity,
      *traversability;
};

/** A map and its frame, as all rules get it. A rule has no member but a reference to it. */
struct Map
{
  Config k;
  LineGrid lines;
  PairGrid pairs;
  CellStore cell;
  PointsIn in;
  Layers out;
  bool with_features;  //!< whether stage 7 stores slope, step, roughness and sparsity
  bool keeps;  //!< whether it keeps what is passable for the next frame
  Channels channels;
  std::uint32_t voxel_mask;  //!< one less than the voxels, a power of two
  struct
  {
    int channel, surface;
    float* out;
  } put;  //!< see PutChannel
  const std::int32_t* moved;  //!< by storage index: 1 where what points to label hit moved away
                              //!< since; null: not yet known
  std::int32_t* notes_moved;  //!< the same, to be found
  FrameCounts* reported;  //!< `counts` of the frame, for the host
#define TALUS_POINTER(type, name, of, first) type* name;
  TALUS_MAP_ARRAYS(TALUS_POINTER)
#undef TALUS_POINTER

  /** Storage index of a cell of the window. */
  TALUS_HD int at(int x, int y) const { return storage_index(*frame, k.cells, x, y); }
  TALUS_HD bool has(int x, int y) const
  {
    return (x >= 0) & (y >= 0) & (x < k.cells) & (y < k.cells);
  }
  /** Index of a cell in layers. */
  TALUS_HD int window_at(int x, int y) const { return y * k.cells + x; }
  TALUS_HD int pair_of(int x, int y) const
  {
    return pairs.at(pairs.pair_at(x, frame->odd_x), pairs.pair_at(y, frame->odd_y));
  }
  TALUS_HD int surface_pitch() const { return k.cells + 2 * k.feature_radius_cells; }
  TALUS_HD int surface_at(int x, int y) const
  {
    return y * surface_pitch() + x + k.feature_radius_cells;
  }
};

template <class Rule, class = void>
constexpr bool kHasApplies = false;
template <class Rule>
constexpr bool kHasApplies<Rule, std::void_t<decltype(&Rule::applies)>> = true;

/** A rule on a cell of the window, where it applies. */
template <class Rule>
TALUS_HD void apply(const Map& m, int x, int y, int i)
{
  const Rule rule{m};
  if constexpr (kHasApplies<Rule>)
    if (!rule.applies(x, y, i)) return;
  rule(x, y, i);
}
/** The same of what else may have two indices. */
template <class Rule>
TALUS_HD void apply(const Map& m, int x, int y)
{
  if constexpr (std::is_invocable_v<Rule, int, int, int>)
    apply<Rule>(m, x, y, m.at(x, y));
  else
    Rule{m}(x, y);
}

/** Rules on a cell, one after the other. */
template <class... Rules>
struct InTurn
{
  const Map& m;

  TALUS_HD void operator()(int x, int y, int i) const { (apply<Rules>(m, x, y, i), ...); }
};

/** Copies the wanted layers of stages 2 to 6 of a cell; the variance has EstimateVariance. */
struct PutSurface
{
  const Map& m;

  TALUS_HD void operator()(int x, int y, int i) const { put(m.out, m.window_at(x, y), i); }
  TALUS_HD void put(const Layers& out, int window_i, int i) const
  {
    const float offset_m = m.frame->offset_m;
    if (out.elevation) out.elevation[window_i] = raised(m.cell.elevation_m[i], offset_m);
    if (out.ground) out.ground[window_i] = raised(m.cell.ground_m[i], offset_m);
    const int state = m.cell.state[i], reach = m.cell.flags[i] & kWasReached;
    if (out.state) out.state[window_i] = static_cast<float>(state);
    if (out.reached)
      out.reached[window_i] = select(
          state == kUnknown, kNan, static_cast<float>(reach) / static_cast<float>(kWasReached));
  }
};

}  // namespace talus::kernels
