#pragma once
#include "kernels/frame.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"

#include <tuple>

namespace talus::kernels
{
enum State : std::uint8_t
{
  kUnknown = 0,
  kMeasured = 1,
  kFilledTwoSided = 2,
  kFilledOneSided = 3,
  kPresumed = 4  //!< the ground on which the robot stood, not measured, see 5_underfoot.h
};

/** Bits: how well rays that passed over a cell show that nothing stands on unmeasured ground there.
 */
enum RayEvidence : std::uint8_t
{
  kPassedLow = 1,  //!< in some frame a ray passed so low that nothing above a step can stand there
  kHitBefore = 2,  //!< when rays passed last, it was hit, too
  kHitHighUp = 4  //!< what was hit there may hang: high above a guess below which no ray passed
};
/** The bits above them hold a trace, see kTraceOne. True: two hits within a few frames, and not
 * long ago. */
TALUS_HD bool hit_lately(int ray_evidence) { return ray_evidence >= kTraceLately; }

/** What the map remembers of a cell; stored it takes 21 bytes. */
struct Cell
{
  float ground_m = kNan;  //!< the lowest surface, map frame; known unless state is kUnknown
  float ground_var_m2 = kNan;
  float elevation_m = kNan;  //!< top of what stands on the ground; NaN where nothing was measured
  float elevation_var_m2 = kNan;
  std::int32_t state = kUnknown;
  std::int32_t persistence =
      0;  //!< consecutive frames that saw through it; negative: see kMaxPersistence
  std::int32_t ray_evidence =
      0;  //!< what rays said of its ground, see RayEvidence, and a trace of hits
  std::int32_t extent = 0;  //!< of what overhangs, below and above its top, see put_extent()
  std::int32_t footing = 0;  //!< whether its ground still holds, see footing()

  static constexpr auto fields()
  {
    return std::make_tuple(
        &Cell::ground_m, &Cell::ground_var_m2, &Cell::elevation_m, &Cell::elevation_var_m2,
        &Cell::state, &Cell::persistence, &Cell::ray_evidence, &Cell::extent, &Cell::footing);
  }
};

/** Above the ground up to there a cell is bare. */
TALUS_HD float bare_up_to_m(float ground_m, const Config& k)
{
  return ground_m + kBare_steps * k.step_threshold_m;
}

/** See kTraceOne. */
TALUS_HD int trace_of(const Cell& c) { return c.ray_evidence & kTraceFull; }

/** Where the map's heights are counted from, from frame to frame, see 3_follow.h. */
struct Datum
{
  float offset_m = 0;  //!< height in the map frame less height as it is kept
  float settled_m = 0;  //!< where slow drift alone would have brought it
  std::int32_t starts_anew = 0;  //!< all cells start empty in the next frame
  /** How high above the ground stood what the robot drove into in the last frame, see
   * Cell::footing. */
  std::int32_t drove_through = 0;
};

/** The persistent layers as a torus: rolling moves no data. */
struct CellStore
{
  float* ground_m;
  float* ground_var_m2;
  float* elevation_m;
  float* elevation_var_m2;
  std::uint8_t* state;
  std::int8_t* persistence;
  std::uint8_t* ray_evidence;
  std::uint8_t* extent;
  std::uint8_t* footing;

  TALUS_HD Cell load(int storage_i) const
  {
    return {ground_m[storage_i],         ground_var_m2[storage_i], elevation_m[storage_i],
            elevation_var_m2[storage_i], state[storage_i],         persistence[storage_i],
            ray_evidence[storage_i],     extent[storage_i],        footing[storage_i]};
  }
  TALUS_HD void store(int storage_i, const Cell& c) const
  {
    ground_m[storage_i] = c.ground_m;
    ground_var_m2[storage_i] = c.ground_var_m2;
    elevation_m[storage_i] = c.elevation_m;
    elevation_var_m2[storage_i] = c.elevation_var_m2;
    state[storage_i] = static_cast<std::uint8_t>(c.state);
    persistence[storage_i] = static_cast<std::int8_t>(c.persistence);
    ray_evidence[storage_i] = static_cast<std::uint8_t>(c.ray_evidence);
    extent[storage_i] = static_cast<std::uint8_t>(c.extent);
    footing[storage_i] = static_cast<std::uint8_t>(c.footing);
  }
};

/** Cell::extent: the low four bits tell how far what overhangs reaches down from the top of its
 * cell, the others how far up, each a code n for about n^2 such units. kOpen, which no two codes
 * give: it lets rays through, a railing. */
constexpr float kExtentUnit_m = 0.0125f;
constexpr int kExtentBits = 4, kMostExtent = 14, kOpen = 255;

TALUS_HD int code_of_extent(float extent_m)
{
  const float units = max_of(extent_m, 0.0f) / kExtentUnit_m;
  return min_of(floor_to_int(sqrtf(units) + 0.5f), kMostExtent);
}
TALUS_HD float extent_of_code(int code) { return static_cast<float>(code * code) * kExtentUnit_m; }
TALUS_HD int extent_of_codes(int below, int above) { return below | above << kExtentBits; }
TALUS_HD int code_below(int extent) { return extent & ((1 << kExtentBits) - 1); }
TALUS_HD int code_above(int extent) { return extent >> kExtentBits; }
/** Reaching down at least so far; kOpen stays. */
TALUS_HD int deeper(int extent, int below)
{
  return extent_of_codes(max_of(code_below(extent), below), code_above(extent));
}

/** Cell::footing: whether its ground may lie far below that around it, until it is measured, see
 * fall_in(); whether a ray passed near its ground, see kPassedNear_steps; the
 * higher bits tell what the robot drove through there: a code n for a height of 4 (n - 1) cm above
 * the ground up to which hits are nothing new, 1: nothing, 0: it was not there. */
constexpr int kMayDrop = 1, kPassedNear = 2, kDrivenBits = 2, kMostDriven = 63;
constexpr float kDrivenUnit_m = 0.04f;

/** How high above the ground hits are nothing new, where the robot was. */
TALUS_HD float driven_through_m(int footing)
{
  return static_cast<float>((footing >> kDrivenBits) - 1) * kDrivenUnit_m;
}
TALUS_HD bool was_robot_there(int footing) { return (footing >> kDrivenBits) != 0; }
/** Whether it drove through something there. */
TALUS_HD bool is_driven(int footing) { return (footing >> kDrivenBits) > 1; }
/** That of a cell on which it stands, where there is nothing new. */
TALUS_HD int footing_driven_over(int footing)
{
  return was_robot_there(footing) ? footing : footing | 1 << kDrivenBits;
}
TALUS_HD int footing_driven_through(float height_m)
{
  const int code = floor_to_int(height_m / kDrivenUnit_m) + 1;
  return min_of(max_of(code, 2), kMostDriven) << kDrivenBits;
}

/** A height that is counted from elsewhere. NaN stays the one that it is: sums make another of it
 * on a device. */
TALUS_HD float raised(float height_m, float by_m)
{
  return select(is_known(height_m), height_m + by_m, kNan);
}

/** Where cell (ix, iy) of the window is stored. */
TALUS_HD int storage_index(const FrameContext& f, int cells, int ix, int iy)
{
  int x = ix + f.storage_x, y = iy + f.storage_y;
  x -= select(x >= cells, cells, 0);
  y -= select(y >= cells, cells, 0);
  return y * cells + x;
}

/** Whether cell (ix, iy) was outside the last window: it starts empty, see stage 3. */
TALUS_HD bool entered_window(const FrameContext& f, int cells, int ix, int iy)
{
  const int old_x = ix + f.moved_x, old_y = iy + f.moved_y;
  return (old_x < 0) | (old_x >= cells) | (old_y < 0) | (old_y >= cells);
}

/** What stage 5 decides about a cell for the rest of the frame. */
enum SurfaceClass : std::uint8_t
{
  kKeep = 0,  //!< its ground stays
  kInfer = 1,  //!< its ground is unknown or a guess: infer it
  kObject = 2,  //!< its lowest surface is no ground but an object above unseen ground: infer the
                //!< ground under it
  kObjectOnColumn = 3,  //!< the same, but it begins where something ends that stands beside it: it
                        //!< cannot hang
  kObjectBesideColumn = 4  //!< the same, but what stands beside it goes on past it, a wall or the
                           //!< post of a sign: it hangs if it is high up
};

/** Where the layers of stages 3 to 7 are wanted, window order; null: not wanted. */
struct SurfaceLayers
{
  float *elevation, *ground, *variance, *state;

  bool any() const { return elevation || ground || variance || state; }
  TALUS_HD void put(int window_i, const CellStore& store, int storage_i, float offset_m) const
  {
    if (elevation) elevation[window_i] = raised(store.elevation_m[storage_i], offset_m);
    if (ground) ground[window_i] = raised(store.ground_m[storage_i], offset_m);
    if (variance) variance[window_i] = store.ground_var_m2[storage_i];
    if (state) state[window_i] = static_cast<float>(store.state[storage_i]);
  }
};

/** Copies the wanted layers of cell (ix, iy), stored at storage_i, to window order. */
struct PutSurface
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  SurfaceLayers out;

  TALUS_HD void operator()(int ix, int iy, int storage_i) const
  {
    out.put(iy * config->cells + ix, store, storage_i, frame->offset_m);
  }
  TALUS_HD void operator()(int ix, int iy) const
  {
    (*this)(ix, iy, storage_index(*frame, config->cells, ix, iy));
  }
};

}  // namespace talus::kernels
