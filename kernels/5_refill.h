#pragma once
#include "kernels/overhang.h"

#include <tuple>

namespace talus::kernels
{
// Stage 5 (III-B.4): which cells are inferred (again) from the updated map. Those are the unknown,
// the guesses, and measured "ground" that turns out to be an object whose ground was never seen.
//
// A measured ground is an object if it is both narrow and steep: it stands above the morphological
// opening of the measured ground (nothing as wide as object_size_m fits below its top: a wall, a
// rock, a branch; but not the edge of a platform or a kerb), and above a cone of the steepest slope
// that ground has over ground close by (so that a ridge or a bank is no object). Both work on pairs
// of cells, and in passes along rows and columns.

/** Cells of the map pooled two by two, by the parity of their place in the map, so that rolling
 * does not change the pairs. In a margin around the window the ground goes on as at its border, or
 * the edge of a platform of which only a strip is inside would be an object. */
struct SupportGrid
{
  int side;  //!< pooled cells along each side, with both margins
  int margin;  //!< in pooled cells
  int pad;  //!< places beside each row that hold infinity
  float* lowest_m;  //!< lowest measured ground, infinity: none
  float* column_m;  //!< highest top of something upright, -infinity: none
  float* overhang_m;  //!< the same of what rays pass below, but not the robot ...
  float* overhang_depth_m;  //!< ... and how far down from it that is known to reach
  float* eroded_m;  //!< lowest ground of the neighbourhood
  float* cone_m;  //!< lowest ground of the neighbourhood, raised with distance
  float* limit_m;  //!< how high ground stands there at most

  TALUS_HD int at(int px, int py) const { return py * (side + 2 * pad) + px + pad; }
  /** Along one axis: where a cell of the window is found. */
  TALUS_HD int place_of(int cell, int odd) const { return ((cell + odd) >> 1) + margin; }
  /** The other way: the pair of cells whose ground a place has, its own or that at the border. */
  TALUS_HD int pair_at(int place, int odd, int cells) const
  {
    return min_of(max_of(place - margin, 0), place_of(cells - 1, odd) - margin);
  }
};

TALUS_HD int support_margin(const Config& k) { return k.object_radius; }
TALUS_HD int support_side(const Config& k) { return k.cells / 2 + 1 + 2 * support_margin(k); }

/** What pooled cells hold. */
struct Support
{
  float lowest_m = kInfinity, column_m = -kInfinity;
  float overhang_m = -kInfinity;
  std::int32_t overhang_below = 0;  //!< code of how far it reaches down, see Cell::extent

  static constexpr auto fields()
  {
    return std::make_tuple(
        &Support::lowest_m, &Support::column_m, &Support::overhang_m, &Support::overhang_below);
  }
};

struct PoolSupport
{
  using Item = Support;
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  SupportGrid grid;

  /** Of the cell stored at i. */
  TALUS_HD Support item(int i) const
  {
    const float ground = store.ground_m[i], top = store.elevation_m[i];
    const bool measured = store.state[i] == kMeasured;
    const bool upright = measured & (top - ground > 0.5f * config->clearance_m);
    const int extent = store.extent[i];
    const float underside = top - extent_of_code(code_below(extent));
    const float robot_m = ground + config->clearance_m + 0.5f * config->step_threshold_m;
    const bool low = (extent == kOpen) | (underside <= robot_m);
    const bool overhangs = upright & low & (store.misses[i] <= -kOverhangCredit);
    return {
        select(measured, ground, kInfinity), select(upright, top, -kInfinity),
        select(overhangs, top, -kInfinity),
        select(overhangs & (extent != kOpen), code_below(extent), 0)};
  }
  /** What two cells hold together, one above the other, or then two such pairs. What stands counts
   * where it stands: a cell that was hit high up only, beside the floor of the other, may hang. */
  TALUS_HD Support pool(const Support& a, const Support& b) const
  {
    const float lowest_m = min_of(a.lowest_m, b.lowest_m);
    const float limit_m = lowest_m + config->clearance_m;
    return {
        lowest_m,
        max_of(
            select(a.lowest_m <= limit_m, a.column_m, -kInfinity),
            select(b.lowest_m <= limit_m, b.column_m, -kInfinity)),
        max_of(a.overhang_m, b.overhang_m), max_of(a.overhang_below, b.overhang_below)};
  }
  /** What goes on beyond the window: bare ground. What is as high as the sensor is not seen from
   * above: it is a face. */
  TALUS_HD Support beyond(const Support& border) const
  {
    const bool bare = border.column_m == -kInfinity, low = border.lowest_m <= frame->sensor_z_m;
    return {select(bare & low, border.lowest_m, kInfinity), -kInfinity, -kInfinity, 0};
  }
  TALUS_HD void put(int px, int py, const Support& pooled) const
  {
    grid.lowest_m[grid.at(px, py)] = pooled.lowest_m;
    grid.column_m[grid.at(px, py)] = pooled.column_m;
    grid.overhang_m[grid.at(px, py)] = pooled.overhang_m;
    grid.overhang_depth_m[grid.at(px, py)] = extent_of_code(pooled.overhang_below);
  }

  TALUS_HD void operator()(int px, int py) const
  {
    const int n = config->cells;
    const int qx = grid.pair_at(px, frame->odd_x, n), qy = grid.pair_at(py, frame->odd_y, n);
    const int x0 = 2 * qx - frame->odd_x, y0 = 2 * qy - frame->odd_y;
    const auto cell = [this, n](int x, int y)
    {
      const bool inside = (x >= 0) & (y >= 0) & (x < n) & (y < n);
      return inside ? item(storage_index(*frame, n, x, y)) : Support{};
    };
    const Support left = pool(cell(x0, y0), cell(x0, y0 + 1));
    const Support pooled = pool(left, pool(cell(x0 + 1, y0), cell(x0 + 1, y0 + 1)));
    const bool inside = qx + grid.margin == px && qy + grid.margin == py;
    put(px, py, inside ? pooled : beyond(pooled));
  }
};

/** Rise of the steepest ground between neighbours of the pooled grid: 45 degrees, or what the robot
 * climbs. */
TALUS_HD float pooled_rise(const Config& k)
{
  return 2.0f * max_of(k.support_slope, 1.0f) * k.resolution_m;
}

/** Lowest ground of a neighbourhood in the pooled grid, plain and raised with distance. */
struct LowestGround
{
  float plain_m = kInfinity, cone_m = kInfinity;

  static constexpr auto fields()
  {
    return std::make_tuple(&LowestGround::plain_m, &LowestGround::cone_m);
  }
};

/** Erosion: along rows first, then across them. Only ground that is known can be as wide as an
 * object may be: behind the face of a wall nothing is known, and does not make it wide. */
struct ErodeSupport
{
  using Row = LowestGround;
  using Window = LowestGround;
  static constexpr bool kHasPlain = false;
  const Config* config;
  SupportGrid grid;

  TALUS_HD const float& neighbour(int px, int py) const { return grid.lowest_m[grid.at(px, py)]; }
  TALUS_HD void add(LowestGround& row, int px, int py, int d) const
  {
    const float ground = neighbour(px + d, py);
    add(row, {ground, ground}, d);
  }
  TALUS_HD void add(LowestGround& sum, const LowestGround& other, int d) const
  {
    const float rise = pooled_rise(*config) * static_cast<float>(abs_of(d));
    sum.plain_m = min_of(sum.plain_m, other.plain_m);
    sum.cone_m = min_of(sum.cone_m, other.cone_m + rise);
  }

  TALUS_HD void operator()(int px, int py, const LowestGround& lowest) const
  {
    grid.eroded_m[grid.at(px, py)] = erode(px, py, lowest, true);
  }
  /** For executors that go on with the result: puts the rest, of places that are the caller's
   * `own`.
   */
  TALUS_HD float erode(int px, int py, const LowestGround& lowest, bool own) const
  {
    if (own) grid.cone_m[grid.at(px, py)] = lowest.cone_m;
    return grid.lowest_m[grid.at(px, py)] < kInfinity ? lowest.plain_m : kInfinity;
  }
};

/** Dilation goes one pair of cells farther than erosion: a pair that holds an edge and the ground
 * below it belongs to what it is the edge of. */
TALUS_HD int dilation_radius(const Config& k) { return k.object_radius + 1; }

/** Highest eroded ground of a neighbourhood; places without any ground do not count. */
struct HighestGround
{
  float height_m = -kInfinity;

  static constexpr auto fields() { return std::make_tuple(&HighestGround::height_m); }
};

/** How high ground may be that is no steeper than ground. */
TALUS_HD float cone_limit_m(const Config& k, float cone_m)
{
  return cone_m + 0.25f * k.step_threshold_m;
}

/** Dilation of what was eroded, and what follows: ground is what is not both narrow and steep. */
struct OpenSupport
{
  using Row = HighestGround;
  using Window = HighestGround;
  static constexpr bool kHasPlain = false;
  const Config* config;
  SupportGrid grid;

  TALUS_HD const float& neighbour(int px, int py) const { return grid.eroded_m[grid.at(px, py)]; }
  TALUS_HD void add(HighestGround& row, int px, int py, int d) const
  {
    add(row, neighbour(px + d, py));
  }
  TALUS_HD void add(HighestGround& row, float eroded_m) const
  {
    row.height_m = max_of(row.height_m, select(eroded_m < kInfinity, eroded_m, -kInfinity));
  }
  TALUS_HD void add(HighestGround& sum, const HighestGround& other, int) const
  {
    sum.height_m = max_of(sum.height_m, other.height_m);
  }

  TALUS_HD void operator()(int px, int py, const HighestGround& opened) const
  {
    const float by_cone_m = cone_limit_m(*config, grid.cone_m[grid.at(px, py)]);
    const float by_width_m = opened.height_m + 0.5f * config->step_threshold_m;
    grid.limit_m[grid.at(px, py)] = max_of(by_cone_m, by_width_m);
  }
};

/** How far behind the face of what it stands on something is hit at most. */
constexpr float kBehindFace_m = 0.4f;

/** The decision for one cell. */
struct ChooseRole
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  SupportGrid grid;
  const float* top_hit_m;  //!< of this frame, by storage index
  Reach reach;
  std::uint8_t* role;  //!< by storage index

  /** Decides for cell (x, y), stored at i, as most are; false where that is all. */
  TALUS_HD bool concerns(int x, int y, int i) const
  {
    const float ground = store.ground_m[i];
    const bool measured = store.state[i] == kMeasured;
    const bool stays = may_be_ground(
        grid.at(grid.place_of(x, frame->odd_x), grid.place_of(y, frame->odd_y)), ground);
    role[i] = static_cast<std::uint8_t>(select(measured, kKeep, kInfer));
    const bool stands_anew = may_join(i, ground) | may_be_bank(i, ground);
    return select(measured, !stays, stands_anew) | may_be_top(i, ground);
  }
  TALUS_HD void operator()(int x, int y, int i) const
  {
    decide(x, y, i);
    if (wants_look(x, y, i)) look(x, y, i, LoneTeam{});
  }

  /** All but what look() does. */
  TALUS_HD void decide(int x, int y, int i) const
  {
    const int px = grid.place_of(x, frame->odd_x), py = grid.place_of(y, frame->odd_y);
    const bool measured = store.state[i] == kMeasured;
    role[i] = measured ? role_of_measured(px, py, store.ground_m[i]) : kInfer;
    if (!measured)
    {
      join_column(i, px, py);
      take_bank(i, grid.at(px, py));
    }
  }

  /** Whether look() has to come next: something that overhangs is before what was hit. */
  TALUS_HD bool wants_look(int x, int y, int i) const
  {
    return may_be_top(i, store.ground_m[i]) && is_before(x, y, face_below(i));
  }

  /** What was hit too high to stand on the ground may belong to a thing whose face overhangs before
   * it. Seen from above it is the top of that thing, a trailer or a car: the robot fits as little
   * below its middle as below its face. Hit above the sensor, right behind the face and without a
   * ray that went on between the two, it stands on that: the cab on a loader, the windows above a
   * car's doors. It has the least credit that such a face may have, and reaches down as far, or to
   * the end of what is hit of it. */
  template <class Team>
  TALUS_HD void look(int x, int y, int i, const Team& team) const
  {
    const float top_m = top_hit_m[i];
    float depth_m = kNan;
    if (seen_from_above(i))
      depth_m = depth_before(x, y, face_below(i), team);
    else
    {
      const OverhangRays<Team> rays{*config, reach, glance_at(*config, *frame, x, y), team};
      const float low_m = rays.end_on_something(top_m);
      const Face face = on_which_stands(low_m, low_m);
      if (is_known(low_m) && is_known(depth_before(x, y, face, team))) depth_m = top_m - low_m;
    }
    if (team.rank() == 0 && is_known(depth_m)) put_overhang(i, depth_m);
  }

 private:
  TALUS_HD bool may_be_ground(int o, float ground_m) const { return ground_m <= grid.limit_m[o]; }
  TALUS_HD bool hit_above(int i, float ground_m) const
  {
    return top_hit_m[i] > ground_m + config->clearance_m;
  }
  /** What is no higher than the sensor cannot be the underside of a roof. */
  TALUS_HD bool seen_from_above(int i) const { return top_hit_m[i] <= frame->sensor_z_m; }
  TALUS_HD bool may_join(int i, float ground_m) const
  {
    return !is_known(store.elevation_m[i]) & hit_above(i, ground_m);
  }
  TALUS_HD bool may_be_top(int i, float ground_m) const
  {
    const bool stands = store.elevation_m[i] > ground_m + 0.5f * config->clearance_m;
    const bool guess = store.state[i] == kFilledOneSided;  // there join_column() decides
    return hit_above(i, ground_m) & !stands & !guess;
  }
  TALUS_HD bool may_be_bank(int i, float ground_m) const
  {
    const float step_m = config->step_threshold_m, top = store.elevation_m[i];
    const bool stands = top > ground_m + step_m;
    const bool hit = abs_of(top_hit_m[i] - top) <= 0.5f * step_m;
    const bool seen_below = (store.misses[i] < 0) | ((store.passed[i] & kHitHighUp) != 0);
    return stands & hit & !seen_below;
  }
  /** What stood over a guess is ground where its top is hit again and is no higher than ground
   * beside it that is wide: of a bank the brink is seen first, a narrow strip with lower ground
   * before it. Below ground no rays pass. */
  TALUS_HD void take_bank(int i, int o) const
  {
    const float top = store.elevation_m[i], by_cone_m = cone_limit_m(*config, grid.cone_m[o]);
    if (!may_be_bank(i, store.ground_m[i]) || !may_be_ground(o, top)) return;
    if (grid.limit_m[o] <= by_cone_m) return;  // no wider than it was
    store.state[i] = kMeasured;
    store.ground_m[i] = top;
    store.ground_var_m2[i] = store.elevation_var_m2[i];
    role[i] = kKeep;
  }
  TALUS_HD void put_overhang(int i, float depth_m) const
  {
    put_top(i);
    store.misses[i] = static_cast<std::int8_t>(-kOverhangCredit);
    store.extent[i] = static_cast<std::uint8_t>(extent_of_codes(code_of_extent(depth_m), 0));
  }
  /** What was hit far above guessed ground hangs there, unless it is joined to something upright: a
   * wall of which this cell was hit high up only. What is seen from above stands until a ray passes
   * low over the guess. */
  TALUS_HD void join_column(int i, int px, int py) const
  {
    if (!may_join(i, store.ground_m[i])) return;
    if (!between_columns(px, py, top_hit_m[i] - config->clearance_m))
    {
      if ((store.passed[i] & kPassedLow) != 0 || !seen_from_above(i)) return;
      store.passed[i] |= kHitHighUp;
    }
    put_top(i);
  }
  TALUS_HD void put_top(int i) const
  {
    store.elevation_m[i] = top_hit_m[i];
    store.elevation_var_m2[i] = config->min_variance_m2;
  }

  TALUS_HD Role role_of_measured(int px, int py, float ground_m) const
  {
    if (may_be_ground(grid.at(px, py), ground_m)) return kKeep;
    const float column_m = column_beside(px, py);
    if (column_m + config->clearance_m < ground_m) return kObject;
    const bool past = column_m > ground_m + 0.5f * config->step_threshold_m;
    return past ? kObjectBesideColumn : kObjectOnColumn;
  }

  /** Whether something upright stands at least so high on two opposite sides of the pooled cell. */
  TALUS_HD bool between_columns(int px, int py, float height_m) const
  {
    const float* at = grid.column_m + grid.at(px, py);
    const int pitch = grid.side + 2 * grid.pad, steps[] = {1, pitch, pitch + 1, pitch - 1};
    for (const int step : steps)
      if (at[-step] >= height_m && at[step] >= height_m) return true;
    return false;
  }

  /** What overhangs and has its top between two heights, at most so many pairs of cells away. */
  struct Face
  {
    float lowest_m, highest_m;
    int reach;
  };
  /** The face of a thing whose top is that high: no farther than a thing reaches that is narrower
   * than ground. */
  TALUS_HD Face whose_top_is_at(float top_m) const
  {
    const float tolerance_m = 0.5f * config->step_threshold_m;
    return {top_m - tolerance_m, top_m + tolerance_m, 2 * dilation_radius(*config)};
  }
  /** The face above which something begins between two heights. */
  TALUS_HD Face on_which_stands(float lowest_m, float highest_m) const
  {
    const float step_m = config->step_threshold_m;
    return {
        lowest_m - 0.75f * step_m, highest_m + 0.5f * step_m,
        floor_to_int(0.5f * kBehindFace_m * config->inverse_resolution + 0.5f)};
  }

  /** The face of what a hit may belong to. */
  TALUS_HD Face face_below(int i) const
  {
    const float top_m = top_hit_m[i];
    return seen_from_above(i) ? whose_top_is_at(top_m) : on_which_stands(-kInfinity, top_m);
  }

  /** Lanes from a cell to the sensor, a pair of cells wide each. */
  struct Lanes
  {
    static constexpr int kCount = 5, kMissing = 1;  //!< so many may be without what is looked for
    int px, py;
    Direction to_sensor;
  };
  TALUS_HD Lanes lanes_from(int x, int y) const
  {
    const auto dx = static_cast<float>(config->cells / 2 - x);
    const auto dy = static_cast<float>(config->cells / 2 - y);
    const float length = max_of(sqrtf(dx * dx + dy * dy), 1.0f);
    return {
        grid.place_of(x, frame->odd_x), grid.place_of(y, frame->odd_y), {dx / length, dy / length}};
  }
  /** The pooled cell nearest in a lane that holds the face; -1: none. */
  TALUS_HD int face_in_lane(const Lanes& lanes, int lane, const Face& face) const
  {
    const Direction d = lanes.to_sensor;
    const auto beside = static_cast<float>(lane - Lanes::kCount / 2);
    const int here = grid.at(lanes.px, lanes.py);  // of no use: what overhangs is before it
    int nearest = -1;
    for (int r = face.reach; r >= 1; r--)  // to the end, so that a device reads ahead
    {
      const float ahead = static_cast<float>(r);
      const int qx = lanes.px + floor_to_int(ahead * d.x - beside * d.y + 0.5f);
      const int qy = lanes.py + floor_to_int(ahead * d.y + beside * d.x + 0.5f);
      const bool inside = (qx >= 0) & (qy >= 0) & (qx < grid.side) & (qy < grid.side);
      const int o = select(inside, grid.at(qx, qy), here);
      const float top_m = grid.overhang_m[o];
      const bool is_face = (o != here) & (top_m >= face.lowest_m) & (top_m <= face.highest_m);
      nearest = select(is_face, o, nearest);
    }
    return nearest;
  }
  /** Whether depth_before() may find the face: it is in one of two lanes. */
  TALUS_HD bool is_before(int x, int y, const Face& face) const
  {
    const Lanes lanes = lanes_from(x, y);
    const int middle = Lanes::kCount / 2;
    return face_in_lane(lanes, middle, face) >= 0 || face_in_lane(lanes, middle + 1, face) >= 0;
  }
  /** How far down reaches what overhangs between a cell and the sensor, in all lanes but one: wider
   * than the leg of a table. NaN: nothing does. */
  template <class Team>
  TALUS_HD float depth_before(int x, int y, const Face& face, const Team& team) const
  {
    const Lanes lanes = lanes_from(x, y);
    int missing = 0;
    float depth_m = 0;
    for (int lane = team.rank(); lane < Lanes::kCount; lane += team.size())
    {
      const int o = face_in_lane(lanes, lane, face);
      if (o < 0)
        missing++;
      else
        depth_m = max_of(depth_m, grid.overhang_depth_m[o]);
    }
    depth_m = team.max(depth_m);
    return team.sum(missing) <= Lanes::kMissing ? depth_m : kNan;
  }

  /** Highest top of something upright in the pooled cell or next to it; of what stands, not of what
   * hangs so high that the robot fits below, as the thing itself that is asked for may. */
  TALUS_HD float column_beside(int px, int py) const
  {
    float column = -kInfinity;
    for (int y = py - 1; y <= py + 1; y++)
      for (int x = px - 1; x <= px + 1; x++)
      {
        const int o = grid.at(x, y);
        const bool stands = grid.lowest_m[o] <= grid.cone_m[o] + config->clearance_m;
        column = max_of(column, select(stands, grid.column_m[o], -kInfinity));
      }
    return column;
  }
};

}  // namespace talus::kernels
