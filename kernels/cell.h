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
  kFilledOneSided = 3
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

/** What the map remembers of a cell; stored it takes 20 bytes. */
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

  static constexpr auto fields()
  {
    return std::make_tuple(
        &Cell::ground_m, &Cell::ground_var_m2, &Cell::elevation_m, &Cell::elevation_var_m2,
        &Cell::state, &Cell::persistence, &Cell::ray_evidence, &Cell::extent);
  }
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

  TALUS_HD Cell load(int storage_i) const
  {
    return {ground_m[storage_i],         ground_var_m2[storage_i], elevation_m[storage_i],
            elevation_var_m2[storage_i], state[storage_i],         persistence[storage_i],
            ray_evidence[storage_i],     extent[storage_i]};
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
  TALUS_HD void put(int window_i, const CellStore& store, int storage_i) const
  {
    if (elevation) elevation[window_i] = store.elevation_m[storage_i];
    if (ground) ground[window_i] = store.ground_m[storage_i];
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
    out.put(iy * config->cells + ix, store, storage_i);
  }
  TALUS_HD void operator()(int ix, int iy) const
  {
    (*this)(ix, iy, storage_index(*frame, config->cells, ix, iy));
  }
};

}  // namespace talus::kernels
