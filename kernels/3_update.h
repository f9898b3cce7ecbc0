#pragma once
#include "kernels/1_points.h"
#include "kernels/map.h"

namespace talus::kernels
{
// Stage 3 (III-B.1). The points of a cell in one frame are a set: all that is computed of them is a
// minimum, a maximum or an exact integer sum, so that their order cannot matter. Nothing here has
// branches, so that a group of threads can share one cell, or one thread update many side by side.

struct HeightPoint
{
  float height_m;
  float variance_m2;
  std::int32_t overhangs = 0;  //!< its neighbour rays passed below it and ended behind it
};

/** Eq. 5 as an innovation gate: the distance to a cell against the deviation of cell and point. */
TALUS_HD bool inside_gate(float a_m, float var_a, float b_m, float var_b, const Config& k)
{
  const float d = a_m - b_m;
  return d * d <= k.gate2 * (on(kGateOfBoth, k) ? var_a + var_b : var_b);
}

/** An integer that orders points by height, and equal heights by `second`. */
TALUS_HD std::int64_t order_key(float height_m, std::uint32_t second)
{
  return static_cast<std::int64_t>(ordered_from_float(height_m)) * 4294967296 + second;
}
TALUS_HD float height_of_key(std::int64_t key)
{
  return float_from_ordered(static_cast<std::int32_t>(key >> 32));
}

/** A condition: points up to this height count. */
struct UpTo
{
  float limit_m = kInfinity;
};

/** The lowest and the highest point; of equal heights that with the smaller variance. */
struct Extremes
{
  std::int64_t low = order_key(kInfinity, 0), high = order_key(-kInfinity, 0);
  /** A point that does not count changes nothing, here and in all reductions below. */
  TALUS_HD void add(const HeightPoint& p, bool counts, const UpTo& asked, const Config&)
  {
    const bool inside = counts & (p.height_m <= asked.limit_m);
    const std::int64_t as_low = order_key(p.height_m, bits_of(p.variance_m2));
    const std::int64_t as_high = order_key(p.height_m, ~bits_of(p.variance_m2));
    low = select(inside & (as_low < low), as_low, low);
    high = select(inside & (as_high > high), as_high, high);
  }
  template <class Group>
  TALUS_HD void join(const Group& group)
  {
    low = group.min(low);
    high = group.max(high);
  }
  TALUS_HD HeightPoint lowest() const
  {
    return {height_of_key(low), float_of_bits(static_cast<std::uint32_t>(low))};
  }
  TALUS_HD HeightPoint highest() const
  {
    return {height_of_key(high), float_of_bits(~static_cast<std::uint32_t>(high))};
  }
};

struct Estimate
{
  float height_m;
  float variance_m2;
};

/** What a surface of a cell is fused from: `base`, and points inside its gate up to a limit. */
struct FusionPlan
{
  float base_m, base_var_m2;
  float limit_m = kInfinity;
  std::int32_t base_is_prior = 0;  //!< the map's estimate is the base, not one of the points
  std::int32_t wanted = 0;  //!< whether the elevation changes at all
};

/** Units of information (2^-8 / m^2) and distance (2^-20 m): integers, so that sums are exact. */
constexpr float kInformation = 256.0f, kDistance = 1048576.0f, kMaxUnits = 2147483392.0f;

/** At most `kMaxUnits` of them, also for NaN: what no cell takes is reckoned all the same. */
TALUS_HD std::int32_t whole_units(float units)
{
  return static_cast<std::int32_t>(min_of(kMaxUnits, units));
}

TALUS_HD std::int32_t information_of(float variance_m2)
{
  return whole_units(kInformation / variance_m2);
}

/** Kalman fusion (eq. 6 and 7, d <= c) of a whole set: its information is a sum. */
struct Fusion
{
  std::int64_t information = 0, weighted_distance = 0;
  TALUS_HD void add(const HeightPoint& p, bool counts, const FusionPlan& plan, const Config& k)
  {
    const bool inside = counts & (p.height_m <= plan.limit_m) &
                        inside_gate(p.height_m, p.variance_m2, plan.base_m, plan.base_var_m2, k);
    const std::int32_t w = select(inside, information_of(p.variance_m2) + 1, 0);
    const float away = (p.height_m - plan.base_m) * kDistance;
    const std::int32_t distance = whole_units(max_of(away, -kMaxUnits));
    information += w;
    weighted_distance += static_cast<std::int64_t>(w) * distance;
  }
  template <class Group>
  TALUS_HD void join(const Group& group)
  {
    information = group.sum(information);
    weighted_distance = group.sum(weighted_distance);
  }
  /** The fused estimate; the base where no point is inside the gate. */
  TALUS_HD Estimate result(const FusionPlan& plan, const Config& k) const
  {
    const std::int32_t prior = select(plan.base_is_prior != 0, information_of(plan.base_var_m2), 0);
    const double all = double_of(information + prior);  // exact, below 2^53
    const auto shift = static_cast<float>(double_of(weighted_distance) / all);
    const float variance = max_of(kInformation / static_cast<float>(all), k.min_variance_m2);
    const bool any = information != 0;
    return {
        select(any, plan.base_m + shift / kDistance, plan.base_m),
        select(any, variance, plan.base_var_m2)};
  }
};

/** Goes up over the points, from the ground or the top of the object, to the first gap that is
 * larger than the robot's clearance. All points above the gap may hang. */
struct ClearanceScan
{
  float top_m;
  TALUS_HD void add(const HeightPoint& p, bool counts, const ClearanceScan& asked, const Config& k)
  {
    const bool higher = counts & (p.height_m > top_m) & (p.height_m <= asked.top_m + k.clearance_m);
    top_m = select(higher, p.height_m, top_m);
  }
  template <class Group>
  TALUS_HD void join(const Group& group)
  {
    top_m = group.max(top_m);
  }
  TALUS_HD bool goes_on(const ClearanceScan& before, float highest_m) const
  {
    return (top_m > before.top_m) & (top_m < highest_m);
  }
};

/** The top of the object that stands for sure, without hits high up; else the ground. */
TALUS_HD float sure_top_m(const Cell& c)
{
  const bool stands = is_known(c.elevation_m) & !c.is(kHitHighUp);
  return select(stands, max_of(c.ground_m, c.elevation_m), c.ground_m);
}

/** Whether all points of a cell are above the first gap that is larger than the clearance. */
TALUS_HD bool all_hang(const Cell& c, const Extremes& ends, const Config& k)
{
  return (c.state != kUnknown) & (ends.lowest().height_m - sure_top_m(c) > k.clearance_m);
}

/** The ground keeps the lowest surface: points inside the gate are fused, a lower point replaces
 * it, higher points are no ground. Any measurement replaces filled ground. */
TALUS_HD FusionPlan plan_ground(const Cell& c, const HeightPoint& low, const Config& k)
{
  const bool measured = c.state == kMeasured;
  const bool fused =
      measured & ((low.height_m >= c.ground_m) |
                  inside_gate(low.height_m, low.variance_m2, c.ground_m, c.ground_var_m2, k));
  FusionPlan plan;
  plan.base_m = select(fused, c.ground_m, low.height_m);
  plan.base_var_m2 = select(fused, c.ground_var_m2, low.variance_m2);
  plan.base_is_prior = select(fused, 1, 0);
  return plan;
}

TALUS_HD bool is_driven_through(const Cell& c, float highest_m)
{
  return was_driven_through(c.driven_height) &
         (highest_m - c.ground_m <= driven_height_m(c.driven_height));
}

TALUS_HD void put_ground(
    Cell& c, bool all_hang, const FusionPlan& plan, const Fusion& fusion, const Config& k)
{
  const bool wanted = !all_hang;
  const Estimate ground = fusion.result(plan, k);
  // If the robot fits between the new ground and the object on the old ground, that may hang.
  const bool hangs =
      wanted & (c.state == kMeasured) & (c.ground_m - ground.height_m > k.clearance_m);
  c.flags |= select(hangs, kHitHighUp, 0);
  c.ground_m = select(wanted, ground.height_m, c.ground_m);
  c.ground_var_m2 = select(wanted, ground.variance_m2, c.ground_var_m2);
  c.state = select(wanted, kMeasured, c.state);
}

/** The elevation keeps the highest point that stands (eq. 6 and 7): inside the gate it is fused, a
 * higher one replaces it, a lower one changes nothing. `high`: the highest up to `top_m`. */
TALUS_HD FusionPlan
plan_elevation(const Cell& c, const HeightPoint& high, float top_m, const Config& k)
{
  const bool has_elevation = is_known(c.elevation_m);
  const bool fused =
      has_elevation &
      inside_gate(high.height_m, high.variance_m2, c.elevation_m, c.elevation_var_m2, k);
  FusionPlan plan;
  plan.base_m = select(fused, c.elevation_m, high.height_m);
  plan.base_var_m2 = select(fused, c.elevation_var_m2, high.variance_m2);
  plan.limit_m = top_m;
  plan.base_is_prior = select(fused, 1, 0);
  const bool lower = has_elevation & !fused & (high.height_m < c.elevation_m);
  plan.wanted = select(lower | is_driven_through(c, high.height_m), 0, 1);
  return plan;
}

TALUS_HD void put_elevation(
    Cell& c, bool all_hang, const FusionPlan& plan, const Fusion& fusion, const Config& k)
{
  const bool wanted = !all_hang & (plan.wanted != 0);
  const Estimate elevation = fusion.result(plan, k);
  c.elevation_m = select(wanted, elevation.height_m, c.elevation_m);
  c.elevation_var_m2 = select(wanted, elevation.variance_m2, c.elevation_var_m2);
  c.elevation_m = select(all_hang, c.elevation_m, max_of(c.elevation_m, c.ground_m));
}

/** What is hit above the first gap, over bare ground, stands until it is known to hang: a wall may
 * be hit high up first, and of a trailer the top is seen but not the underside. */
TALUS_HD void put_high_hit(Cell& c, float top_m, const HeightPoint& high, const Config& k)
{
  const bool bare = top_m <= bare_up_to_m(c.ground_m, k);
  const bool hangs = ((c.flags & (kPassedBelow | kRobotWasThere)) != 0) | !on(kHighHitStands, k);
  const bool above = bare & (high.height_m > top_m) & !hangs;
  const bool higher = above & !(c.elevation_m >= high.height_m);
  c.elevation_m = select(higher, high.height_m, c.elevation_m);
  c.elevation_var_m2 = select(higher, high.variance_m2, c.elevation_var_m2);
  c.flags = select(bare, c.flags, c.flags & ~kHitHighUp) | select(above, kHitHighUp, 0);
}

/** The lowest point that overhangs the ground or the object below; infinity: none does. */
struct Overhang
{
  float lowest_m = kInfinity;
  TALUS_HD void add(const HeightPoint& p, bool counts, const UpTo& asked, const Config&)
  {
    const bool overhangs = counts & (p.height_m <= asked.limit_m) & (p.overhangs != 0);
    lowest_m = select(overhangs & (p.height_m < lowest_m), p.height_m, lowest_m);
  }
  template <class Group>
  TALUS_HD void join(const Group& group)
  {
    lowest_m = group.min(lowest_m);
  }
};

/** Hits higher than the clearance are no overhang, unless they are the top of the object. */
TALUS_HD UpTo overhangs_up_to(const Cell& c, const Config& k)
{
  return {select(c.is(kHitHighUp), kInfinity, c.ground_m + k.clearance_m)};
}

/** An overhang gets its stay, and its lowest hit; not if the robot drove through the top. */
TALUS_HD void put_overhang(Cell& c, const Overhang& overhang, const Config& k)
{
  const bool any =
      on(kOverhangStays, k) & (overhang.lowest_m < kInfinity) & is_known(c.elevation_m);
  const float down_m = select(any, c.elevation_m - overhang.lowest_m, 0.0f);
  c.stay_frames = select(any, kOverhangStays_frames, c.stay_frames);
  c.frames_against = select(any, 0, c.frames_against);
  c.overhang_below = max_of(c.overhang_below, select(any, overhang_units(down_m), 0));
}

/** Stage 3 on cells that received points: on one, or on several side by side. `Cells` loops over
 * them by each(f), which calls f(l), and adds the points of each to a sum. */
template <class Cells, template <class> class Lanes>
class CellUpdate
{
 public:
  TALUS_HD void run(const Config& k)
  {
    each([&](int l) { up_to_.store(l, {}); });
    reduce(ends, up_to_, k);
    each([&](int l) { hangs_.store(l, {all_hang(cells.load(l), ends.load(l), k)}); });
    const auto ground = [&](int l) { return plan_ground(cells.load(l), ends.load(l).lowest(), k); };
    fuse(k, ground, put_ground);
    scan_clearance(k);
    const auto elevation = [&](int l)
    {
      const HeightPoint high = highest_.load(l).highest();
      return plan_elevation(cells.load(l), high, scan_.load(l).top_m, k);
    };
    fuse(k, elevation, put_elevation);
    each_cell([&](Cell& c, int l)
              { put_high_hit(c, scan_.load(l).top_m, ends.load(l).highest(), k); });
    each([&](int l) { up_to_.store(l, overhangs_up_to(cells.load(l), k)); });
    reduce(overhang_, up_to_, k);
    each_cell([&](Cell& c, int l) { put_overhang(c, overhang_.load(l), k); });
  }

  Lanes<Cell> cells;
  Lanes<Extremes> ends;

 private:
  struct Hangs
  {
    std::int32_t all = 0;
  };

  /** Fuses the points of each plan(l), and puts the result into the cell. */
  template <class Plan, class Put>
  TALUS_HD void fuse(const Config& k, const Plan& plan, const Put& put)
  {
    each([&](int l) { plan_.store(l, plan(l)); });
    reduce(fusion_, plan_, k);
    each_cell([&](Cell& c, int l)
              { put(c, hangs_.load(l).all != 0, plan_.load(l), fusion_.load(l), k); });
  }

  /** Finds the highest point that stands, and the highest up to there. */
  TALUS_HD void scan_clearance(const Config& k)
  {
    std::int32_t any = 0;
    each([&](int l) { scan_.store(l, {sure_top_m(cells.load(l))}); });
    const auto is_below = [&](int l)
    { return select(scan_.load(l).top_m < ends.load(l).highest().height_m, 1, 0); };
    each([&](int l) { any |= is_below(l); });
    while (any)
    {
      last_ = scan_;
      own().add(scan_, last_, k);
      any = 0;
      each([&](int l)
           { any |= scan_.load(l).goes_on(last_.load(l), ends.load(l).highest().height_m); });
    }
    each([&](int l) { any |= is_below(l), up_to_.store(l, {scan_.load(l).top_m}); });
    highest_ = ends;
    if (any) reduce(highest_, up_to_, k);
  }

  TALUS_HD Cells& own() { return static_cast<Cells&>(*this); }
  template <class F>
  TALUS_HD void each(const F& f)
  {
    own().each_lane(f);
  }
  template <class F>
  TALUS_HD void each_cell(const F& f)
  {
    each(
        [&](int l)
        {
          Cell c = cells.load(l);
          f(c, l);
          cells.store(l, c);
        });
  }
  template <class Sum, class Question>
  TALUS_HD void reduce(Lanes<Sum>& sums, const Lanes<Question>& asked, const Config& k)
  {
    each([&](int l) { sums.store(l, {}); });
    own().add(sums, asked, k);
  }

  Lanes<UpTo> up_to_;
  Lanes<Hangs> hangs_;
  Lanes<Extremes> highest_;
  Lanes<FusionPlan> plan_;
  Lanes<Fusion> fusion_;
  Lanes<ClearanceScan> scan_, last_;
  Lanes<Overhang> overhang_;
};

template <class T>
struct OneLane
{
  T value{};
  TALUS_HD T load(int) const { return value; }
  TALUS_HD void store(int, const T& v) { value = v; }
};

template <class Group>
class OneCell : public CellUpdate<OneCell<Group>, OneLane>
{
 public:
  TALUS_HD OneCell(const HeightPoint* points, int size, const Group& group)
      : points_(points), size_(size), group_(group)
  {
  }
  template <class F>
  TALUS_HD void each_lane(const F& f)
  {
    f(0);
  }
  template <class Sum, class Question>
  TALUS_HD void add(OneLane<Sum>& sum, const OneLane<Question>& asked, const Config& k)
  {
    for (int i = group_.rank(); i < size_; i += group_.size())
      sum.value.add(points_[i], true, asked.value, k);
    sum.value.join(group_);
  }

 private:
  const HeightPoint* points_;
  int size_;
  Group group_;
};

/** A cell with more points is crowded, where a group updates it: on devices. */
constexpr std::uint32_t kCrowd = 4;
/** Two ends in one number of 64 bits, so that one atomic operation reserves memory of both. */
struct SortEnds
{
  std::uint32_t sorted;  //!< points in Map::sorted
  int crowded;  //!< cells in Map::crowded
};
constexpr std::uint64_t kOneCrowded = 1ull << 32;
TALUS_HD SortEnds ends_of(std::uint64_t cursor)
{
  return {static_cast<std::uint32_t>(cursor), static_cast<int>(cursor >> 32)};
}

struct SortPoint
{
  const Map& m;

  /** Whether rays passed below a point in its own direction and in two on each side. Beside the
   * edge of an object rays pass on one side only. */
  TALUS_HD bool overhangs(int point_i) const
  {
    return passed_below(point_i, 0) && (passed_below(point_i, -1) & passed_below(point_i, 1) &
                                        passed_below(point_i, -2) & passed_below(point_i, 2));
  }
  /** Beyond range noise and round sides: hits farther behind are on another object. */
  TALUS_HD int rings_behind() const
  {
    return max_of(
        kBehindOverhang_rings, floor_to_int(kBehindOverhang_m * m.k.inverse_resolution + 0.5f));
  }
  TALUS_HD bool passed_below(int point_i, int beside) const
  {
    const bool aims = (m.point_ray[point_i] >= 0) & (m.point_cell[point_i] >= 0);
    const int at = select(aims, m.point_ray[point_i], 0), bins = bin_count(m.k);
    const int ring = floor_div(at, bins, 1.0f / static_cast<float>(bins)), bin = at - ring * bins;
    const int behind = min_of(ring + rings_behind(), m.frame->rings - 1);
    const std::int32_t lowest = m.rays[behind * bins + wrap_bin(bin + beside, bins)];
    const float chebyshev_m = (static_cast<float>(ring) + 0.5f) * m.k.resolution_m;
    const float limit = m.point_slope[point_i] - m.k.cleanup_margin_m / chebyshev_m;
    return aims & (lowest != kNoRay) & !(float_from_ordered(lowest) > limit);
  }

  TALUS_HD void put(int point_i, std::uint32_t rank, bool overhangs) const
  {
    m.sorted[m.cell_begin[m.point_cell[point_i]] + rank] = {
        m.point_height_m[point_i] - m.frame->offset_m, m.point_variance_m2[point_i],
        select(overhangs, 1, 0)};
  }

  TALUS_HD void put(int point_i, bool overhangs) const
  {
    if (m.point_cell[point_i] >= 0 && m.point_rank[point_i] != kNoRank)
      put(point_i, m.point_rank[point_i], overhangs);
  }
};

/** Stage 3 on the cell of its first point, or on a crowded cell. */
struct UpdateCell
{
  const Map& m;

  /** The cell to update for point i, or -1. */
  TALUS_HD int lone_cell(int point_i) const
  {
    if (point_i >= m.frame->n_points || m.point_cell[point_i] < 0 || m.point_rank[point_i] != 0)
      return -1;
    return m.cell_count[m.point_cell[point_i]] <= kCrowd ? m.point_cell[point_i] : -1;
  }
  /** The crowded cell in a slot, or -1 if there is none. */
  TALUS_HD int crowded_cell(int slot) const
  {
    return slot < ends_of(*m.cursor).crowded ? m.crowded[slot] : -1;
  }

  /** Stores the updated cell, unless the update rests on a single point. */
  TALUS_HD void put(int storage_i, const Cell& updated, const Extremes& ends) const
  {
    Cell c = updated;
    // Rays from below end at the underside of what is above the sensor: it hangs.
    const bool free = (c.state == kMeasured) | c.is(kPassedLow);
    if (free && c.is(kHitHighUp) && ends.highest().height_m > m.frame->sensor_z_m)
    {
      if (m.cell.is(kHitHighUp, storage_i) && m.cell.elevation_m[storage_i] <= m.frame->sensor_z_m)
        c.elevation_m = m.cell.elevation_m[storage_i];  // what is below that is another object
      else
        remove_object(c);
    }
    const float bare_m = bare_up_to_m(m.cell.ground_m[storage_i], m.k);
    const bool seen = (m.cell.state[storage_i] == kMeasured) | m.cell.is(kPassedLow, storage_i);
    const bool was_bare = seen & !(m.cell.elevation_m[storage_i] > bare_m);
    float top_m = ends.highest().height_m;
    if (was_bare && top_m > bare_m && is_alone(storage_i, top_m, bare_m))
    {
      const Cell before = m.cell.load(storage_i);
      c.stay_frames = before.stay_frames, c.frames_against = before.frames_against;
      if (!lone_hit_counts(before.recent_hits))
        top_m = refuse(c, before, ends.lowest().height_m, bare_m);
    }
    m.cell.store(storage_i, c);
    m.top_hit_m[storage_i] = top_m;
  }

  template <class Group>
  TALUS_HD void update(int storage_i, const Group& group) const
  {
    const int size = static_cast<int>(m.kept_count[storage_i]);
    if (size == 0) return;
    OneCell<Group> here{m.sorted + m.cell_begin[storage_i], size, group};
    here.cells.value = m.cell.load(storage_i);
    here.run(m.k);
    if (group.rank() == 0) put(storage_i, here.cells.value, here.ends.value);
  }

 private:
  /** Counts the points of cells that lie above bare ground and near to `top_m`, at least up to more
   * than kOthersBesideHit. The loads come first, so that they do not wait for each other. */
  template <int kCells>
  TALUS_HD int points_beside(const int (&cells)[kCells], float top_m, float bare_m) const
  {
    constexpr int kBatch = kCells == 1 ? 8 : 2;
    std::uint32_t begin[kCells];
    int size[kCells], max_size = 0;
    for (int c = 0; c < kCells; c++)
    {
      const int i = max_of(cells[c], 0);
      begin[c] = m.cell_begin[i];
      size[c] = select(cells[c] < 0, 0, static_cast<int>(m.kept_count[i]));
    }
    for (int c = 0; c < kCells; c++) max_size = max_of(max_size, size[c]);
    int beside = 0;
    for (int first = 0; first < max_size && beside <= kOthersBesideHit; first += kBatch)
    {
      float height_m[kCells * kBatch];
      for (int b = 0; b < kCells * kBatch; b++)
      {
        const int c = b / kBatch, p = first + b % kBatch;
        height_m[b] = p < size[c] ? (m.sorted + begin[c])[p].height_m : -kInfinity;
      }
      for (int b = 0; b < kCells * kBatch; b++)
      {
        const bool near = abs_of(height_m[b] - top_m) <= kBesideHit_steps * m.k.step_threshold_m;
        beside += select((height_m[b] > bare_m) & near, 1, 0);
      }
    }
    return beside;
  }
  /** Whether fewer than kOthersBesideHit other points are near to the top of a cell. The cell
   * itself comes first, since most objects fill it with hits. */
  TALUS_HD bool is_alone(int storage_i, float top_m, float bare_m) const
  {
    if (!on(kLoneHits, m.k)) return false;
    const int n = m.k.cells, y = floor_div(storage_i, n), x = storage_i - y * n;
    int beside = points_beside({storage_i}, top_m, bare_m);
    for (int dy = -kBesideHit_cells; dy <= kBesideHit_cells && beside <= kOthersBesideHit; dy++)
    {
      int row[2 * kBesideHit_cells + 1];
      for (int dx = -kBesideHit_cells; dx <= kBesideHit_cells; dx++)
      {
        const int i = wrap_bin(y + dy, n) * n + wrap_bin(x + dx, n);
        row[dx + kBesideHit_cells] = select(i == storage_i, -1, i);
      }
      beside += points_beside(row, top_m, bare_m);
    }
    return beside <= kOthersBesideHit;
  }
  /** Drops the hit and counts it; the ground may change. Returns the highest hit that remains. */
  TALUS_HD float refuse(Cell& c, const Cell& before, float lowest_m, float bare_m) const
  {
    const bool floor = lowest_m <= bare_m;
    if (!floor) c = before;
    c.elevation_m = select(c.state == kMeasured, c.ground_m, before.elevation_m);
    c.elevation_var_m2 = select(c.state == kMeasured, c.ground_var_m2, before.elevation_var_m2);
    c.overhang_below = before.overhang_below, c.overhang_above = before.overhang_above;
    c.flags = before.flags;
    c.recent_hits = before.recent_hits;
    add_hit(c);
    return select(floor, lowest_m, -kInfinity);
  }
};

}  // namespace talus::kernels
