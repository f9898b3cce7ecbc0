#pragma once
#include "kernels/frame.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"

#include <cstddef>
#include <type_traits>

namespace talus::kernels
{
enum State : std::uint8_t
{
  kUnknown = 0,
  kMeasured = 1,
  kFilledTwoSided = 2,
  kFilledOneSided = 3,
  kPresumed = 4  //!< ground on which the robot stood or started, see 4_underfoot.h
};

/** Bits of Cell::flags: evidence. Compilers do not vectorise a test of the lowest one. */
enum CellFlag : std::uint8_t
{
  kWasPassable = 1,  //!< in the last frame
  kPassedLow = 2,  //!< in some frame rays proved its ground to be free, see proof_m()
  kPassedBelow = 4,  //!< rays passed below what is high up there, as high as the robot
  kHitHighUp = 8,  //!< its object is above a gap that is larger than the clearance, and may hang
  kWasReached = 16,  //!< the robot gets there, see 4_reach.h
  kPossibleDropOff = 32,  //!< its ground may lie far below the ground around it, see fall_in()
  kObjectTop = 64,  //!< it was passable, not reached and above reached ground: the top of an object
  kRobotWasThere = 128
};

// The fields of a cell, one line each: FIELD(type, name, value where nothing is known). Store,
// buffers, saved maps, records and tiles follow this list. Heights count from the map's datum; what
// is measured is fused into ground and elevation, the rest is evidence in eight bits.

#define TALUS_CELL_SURFACES(FIELD)                                                     \
  FIELD(float, ground_m, kernels::kNan) /* the lowest surface; NaN only in kUnknown */ \
  FIELD(float, ground_var_m2, kernels::kNan)                                           \
  FIELD(float, elevation_m, kernels::kNan) /* top of the object; NaN: not measured */  \
  FIELD(float, elevation_var_m2, kernels::kNan)                                        \
  FIELD(std::uint8_t, state, kernels::kUnknown) /* a State */

// Lasting evidence first, then kTransientFields. Functions below say what a number means.
#define TALUS_CELL_EVIDENCE(FIELD)                                                     \
  FIELD(std::uint8_t, flags, 0) /* CellFlag */                                         \
  FIELD(std::uint8_t, stay_frames, 0) /* countdown without a hit, see overhangs() */   \
  FIELD(std::uint8_t, overhang_below, 0) /* length of the overhang below the top */    \
  FIELD(std::uint8_t, overhang_above, 0) /* and above the top [kOverhangUnit_m] */     \
  FIELD(std::uint8_t, driven_height, 0) /* see was_driven_through() */                 \
  FIELD(std::uint8_t, frames_against, 0) /* consecutive frames that deny the object */ \
  FIELD(std::uint8_t, recent_hits, 0) /* score of recent frames, see add_hit() */

#define TALUS_CELL_FIELDS(FIELD) TALUS_CELL_SURFACES(FIELD) TALUS_CELL_EVIDENCE(FIELD)

/** The number of evidence bytes, and how many of them, at the end, belong to the latest frames. */
#define TALUS_COUNT(type, name, unknown) +1
constexpr int kEvidenceFields = TALUS_CELL_EVIDENCE(TALUS_COUNT), kTransientFields = 2;
#undef TALUS_COUNT
#define TALUS_SIZE(type, name, unknown) +sizeof(type)
constexpr std::size_t kBytesPerCell = TALUS_CELL_FIELDS(TALUS_SIZE);
#undef TALUS_SIZE

/** In registers small numbers are as wide as all others. */
template <class Stored>
using InRegister = std::conditional_t<std::is_same_v<Stored, float>, float, std::int32_t>;

struct Cell
{
#define TALUS_MEMBER(type, name, unknown) InRegister<type> name = unknown;
  TALUS_CELL_FIELDS(TALUS_MEMBER)
#undef TALUS_MEMBER

  TALUS_HD bool is(CellFlag flag) const { return (flags & flag) != 0; }
};

/** The cells of the map, one array for each field. It is a torus, so that rolling moves no data. */
struct CellStore
{
#define TALUS_ARRAY(type, name, unknown) type* name;
  TALUS_CELL_FIELDS(TALUS_ARRAY)
#undef TALUS_ARRAY

  TALUS_HD bool is(CellFlag flag, int storage_i) const { return (flags[storage_i] & flag) != 0; }
  TALUS_HD Cell load(int storage_i) const
  {
    Cell c;
#define TALUS_LOAD(type, name, unknown) c.name = name[storage_i];
    TALUS_CELL_FIELDS(TALUS_LOAD)
#undef TALUS_LOAD
    return c;
  }
  TALUS_HD void store(int storage_i, const Cell& c) const
  {
#define TALUS_STORE(type, name, unknown) name[storage_i] = static_cast<type>(c.name);
    TALUS_CELL_FIELDS(TALUS_STORE)
#undef TALUS_STORE
  }
};

/** Cell::recent_hits is a score: frames with a hit add to it, frames of passing rays subtract. */
TALUS_HD void add_hit(Cell& c) { c.recent_hits = min_of(c.recent_hits + kHitAdds, kMaxRecentHits); }
/** Whether a lone hit counts: there were two hits within a few frames, not long ago. */
TALUS_HD bool lone_hit_counts(int recent_hits) { return recent_hits >= kLoneHitCounts; }
/** Whether an object left a cell that is bare now, or a lone hit waits there for a second one. */
TALUS_HD bool object_left(int recent_hits) { return recent_hits > 0; }
TALUS_HD void note_object_left(Cell& c) { c.recent_hits = max_of(c.recent_hits, kHitAdds); }

/** Whether the object is an overhang: its stay has not run out. */
TALUS_HD bool overhangs(int stay_frames) { return stay_frames > 0; }

/** A cell is bare up to this height. */
TALUS_HD float bare_up_to_m(float ground_m, const Config& k)
{
  return ground_m + kBare_steps * k.step_threshold_m;
}

/** The zero of the map's heights, kept from frame to frame, see 2_follow.h. */
struct Datum
{
  float offset_m = 0;  //!< height in the map frame less height as it is kept
  std::int32_t starts_anew = 0;  //!< all cells start empty in the next frame
  /** What the robot drove through in the last frame, see Cell::driven_height. */
  std::int32_t drove_through = 0;
};

/** Lengths of overhangs are stored as square numbers of this unit: finer where they are short. */
constexpr float kOverhangUnit_m = 0.0125f;
constexpr int kMaxOverhangRoot = 14;

TALUS_HD int overhang_units(float length_m)
{
  const float units = max_of(length_m, 0.0f) / kOverhangUnit_m;
  const int root = min_of(floor_to_int(sqrtf(units) + 0.5f), kMaxOverhangRoot);
  return root * root;
}
TALUS_HD float overhang_m(int units) { return static_cast<float>(units) * kOverhangUnit_m; }
/** Takes the object from a cell, and what is known of it. */
TALUS_HD void remove_object(Cell& c)
{
  const bool measured = c.state == kMeasured;
  c.elevation_m = select(measured, c.ground_m, kNan);
  c.elevation_var_m2 = select(measured, c.ground_var_m2, kNan);
  c.stay_frames = c.frames_against = c.overhang_below = c.overhang_above = 0;
  c.flags &= ~(kHitHighUp | kObjectTop);
}

/** Unit of Cell::driven_height: hits up to that height above the ground are not new. */
constexpr float kDrivenUnit_m = 0.04f;
constexpr int kMaxDriven = 62;
/** Whether the robot drove through an object there; it only stood at kRobotWasThere. */
TALUS_HD bool was_driven_through(int driven_height) { return driven_height > 0; }
TALUS_HD float driven_height_m(int driven_height)
{
  return static_cast<float>(driven_height) * kDrivenUnit_m;
}
TALUS_HD int driven_units(float height_m)
{
  return min_of(max_of(floor_to_int(height_m / kDrivenUnit_m), 1), kMaxDriven);
}

/** A height above another datum. NaN keeps its bits, since a sum would change them on a device. */
TALUS_HD float raised(float height_m, float by_m)
{
  return select(is_known(height_m), height_m + by_m, kNan);
}

/** Storage index of cell (ix, iy) of the window. */
TALUS_HD int storage_index(const FrameContext& f, int cells, int ix, int iy)
{
  int x = ix + f.storage_x, y = iy + f.storage_y;
  x -= select(x >= cells, cells, 0);
  y -= select(y >= cells, cells, 0);
  return y * cells + x;
}

/** The cells [first, end) of a row. */
struct Stretch
{
  int first, end;
  TALUS_HD bool has(int ix) const { return (ix >= first) & (ix < end); }
};
/** The cells of a row that were in the last window; none if all `start` anew. */
TALUS_HD Stretch staying(const FrameContext& f, int cells, int iy, bool start)
{
  const int old_y = iy + f.moved_y;
  const bool none = (old_y < 0) | (old_y >= cells) | start;
  return {
      select(none, cells, max_of(-f.moved_x, 0)),
      select(none, cells, min_of(cells - f.moved_x, cells))};
}
TALUS_HD bool entered_window(const FrameContext& f, int cells, int ix, int iy)
{
  return !staying(f, cells, iy, false).has(ix);
}

/** The decision of stage 4 about a cell, for the rest of the frame. */
enum SurfaceClass : std::uint8_t
{
  kKeep = 0,  //!< its ground stays
  kInfer = 1,  //!< its ground is unknown or a guess: infer it
  kObject = 2  //!< its lowest surface is an object above unseen ground: infer the
               //!< ground under it
};

// What stage 6 hands to stage 7.

constexpr std::int32_t kNoHeight = -0x7fffffff - 1;

/** Flags of a Surface. The lowest bit is free, as in CellFlag. */
enum SurfaceFlag : std::int32_t
{
  kSurfaceSeen = 2,  //!< a ray hit it or passed low over its ground, or the robot stood there
  kSurfacePossibleDropOff = 4,  //!< its ground was not seen and may lie far below that around it
  kSurfaceDriven = 8  //!< the robot drove over it, and no new object stands there
};

constexpr int kSurfaceFlags = 4;

/** The surfaces of one cell, quantised, for stage 7. */
struct alignas(8) Surface
{
  std::int32_t ground;  //!< kNoHeight: unknown
  /** The elevation (the ground without an object) above the bits of the flags. */
  std::int32_t height_and_flags;

  TALUS_HD bool known() const { return ground != kNoHeight; }
  TALUS_HD std::int32_t height() const { return height_and_flags >> kSurfaceFlags; }
  TALUS_HD bool is(SurfaceFlag flag) const { return (height_and_flags & flag) != 0; }
};

}  // namespace talus::kernels
