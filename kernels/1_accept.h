#pragma once
#include "kernels/atomics.h"
#include "kernels/rays.h"
#include "kernels/2_uncertainty.h"
#include "kernels/3_roll.h"

namespace talus::kernels
{
/** Why a point is not accepted; the values of talus::Reject. */
enum RejectCode : int
{
  kNotFinite = 0,
  kRange,
  kHeight,
  kBody,
  kOutside,
  kVoxel,
  kBuried,
  kRejectCodes,
  kAccepted = kRejectCodes
};

struct Point
{
  float x_m, y_m, z_m;
};

/** What stage 1 says of a point. */
struct Verdict
{
  int code;  //!< a RejectCode
  /** Its ray counts. That of a point outside the height band does: the space before it is free. */
  std::int32_t seen;
};

/** Stage 1 on one point of the sensor frame (III-A.1): range, the robot's body, the height band. Of
 * several reasons the first in this order counts. */
TALUS_HD Verdict accept(const Point& p, const Config& k)
{
  const float range2 = p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m;
  const bool finite = is_finite(p.x_m) & is_finite(p.y_m) & is_finite(p.z_m);
  const bool in_range = (range2 >= k.min_range2_m2) & (range2 <= k.max_range2_m2);
  const bool in_body = (k.has_body != 0) & (p.x_m >= k.body_min_m[0]) & (p.x_m <= k.body_max_m[0]) &
                       (p.y_m >= k.body_min_m[1]) & (p.y_m <= k.body_max_m[1]) &
                       (p.z_m >= k.body_min_m[2]) & (p.z_m <= k.body_max_m[2]);
  const bool in_band = (p.z_m >= k.min_height_m) & (p.z_m <= k.max_height_m);
  int code = select(in_band, kAccepted, kHeight);
  code = select(in_body, kBody, code);
  code = select(in_range, code, kRange);
  const std::int32_t seen = select(finite & in_range & !in_body, 1, 0);
  return {select(finite, code, kNotFinite), seen};
}

/** Eq. 1: sensor frame to window frame. */
TALUS_HD Point transform(const WindowPose& pose, const Point& p)
{
  const float* m = pose.m;
  return {
      m[0] * p.x_m + m[1] * p.y_m + m[2] * p.z_m + m[3],
      m[4] * p.x_m + m[5] * p.y_m + m[6] * p.z_m + m[7],
      m[8] * p.x_m + m[9] * p.y_m + m[10] * p.z_m + m[11]};
}

/** The pose at a point's time: linear between the path's poses, which lie so close together that
 * this is exact to rounding (deskew). */
TALUS_HD WindowPose pose_at(const FrameContext& f, float time_s)
{
  const float last = static_cast<float>(f.n_poses - 1);
  const float place = (time_s - f.path_start_s) * f.path_rate_hz;
  const float at = place > 0.0f ? min_of(place, last) : 0.0f;  // a time that is NaN is the first
  const int before = min_of(floor_to_int(at), f.n_poses - 2);
  const float w = at - static_cast<float>(before);
  WindowPose pose;
  for (int i = 0; i < 12; i++)
  {
    const float a = f.poses[before].m[i], b = f.poses[before + 1].m[i];
    pose.m[i] = a + w * (b - a);
  }
  return pose;
}

/** The points of a frame, sensor frame, one array a coordinate. */
struct PointsIn
{
  const float* x_m;
  const float* y_m;
  const float* z_m;
  const float* time_s;  //!< read only where FrameContext::has_times
};

/** A stretch of places, for one of several threads. */
struct Part
{
  int begin, end;
};

/** Of a point that is in a cell and does not count. */
constexpr std::uint32_t kNoRank = ~0u;

/** What stages 1 and 2 leave of each point. */
struct PointsOut
{
  std::int32_t* cell;  //!< storage index, or -1: not in the map
  std::int32_t* ray;  //!< place in the table of rays, or -1: no direction
  float* slope;  //!< of that ray
  std::uint32_t* rank;  //!< place among the points of its cell, in any order; or kNoRank
  float* height_m;  //!< map frame
  float* variance_m2;
};

/** Notes the ray that a point ended. */
template <class Atomics>
struct NoteRay
{
  const Config* config;
  PointsOut points;
  std::int32_t*
      rays;  //!< [ring][bin], lowest slope of what was hit in that ring, as an ordered integer

  /** Of the directions. */
  Part part(int which, int of) const
  {
    const int bins = bin_count(*config);
    return {which * bins / of, (which + 1) * bins / of};
  }
  bool is_in(const Part& part, int i) const
  {
    const int bins = bin_count(*config), at = max_of(points.ray[i], 0);
    const int bin = at - floor_div(at, bins, 1.0f / static_cast<float>(bins)) * bins;
    return (bin >= part.begin) & (bin < part.end);
  }
  TALUS_HD void operator()(int i) const
  {
    const int at = points.ray[i];
    if (at >= 0) Atomics::min(rays + at, ordered_from_float(points.slope[i]));
  }
};

/** Stages 1 and 2: transforms, accepts and weighs one point, and notes the ray that it ended. */
template <class Atomics>
struct AcceptPoint
{
  const Config* config;
  const FrameContext* frame;
  PointsIn in;
  PointsOut out;
  std::int32_t* rays;  //!< see NoteRay
  std::uint32_t* rejected;  //!< by RejectCode
  const std::uint8_t* voxel_kept;  //!< null: no voxel filter

  /** What depends on this point alone. PointsOut::rank holds its RejectCode until note(). */
  TALUS_HD void locate(int i) const { locate(i, point(i)); }
  TALUS_HD void locate(int i, const Point& sensed) const
  {
    const bool moves = frame->n_poses > 1 && frame->has_times;
    put(i, sensed,
        moves ? transform(pose_at(*frame, in.time_s[i]), sensed)
              : transform(frame->poses[0], sensed),
        !voxel_kept || voxel_kept[i]);
  }

  /** Whether locate_plain() is the same as locate(): no voxel filter, no motion during the scan. */
  TALUS_HD bool is_plain() const
  {
    return !voxel_kept && !(frame->n_poses > 1 && frame->has_times);
  }
  TALUS_HD void locate_plain(int i) const
  {
    const Point sensed = point(i);
    put(i, sensed, transform(frame->poses[0], sensed), true);
  }

  /** What it shares with other points. */
  TALUS_HD void note(int i) const
  {
    NoteRay<Atomics>{config, out, rays}(i);
    if (out.rank[i] != kAccepted) Atomics::count(rejected + out.rank[i]);
  }
  /** Counts the rejected among the points [begin, end), after locate(). */
  void count_rejected(int begin, int end) const
  {
    for (std::uint32_t code = 0; code < kRejectCodes; code++)
    {
      std::uint32_t n = 0;
      for (int i = begin; i < end; i++) n += out.rank[i] == code;
      if (n) Atomics::add(rejected + code, n);
    }
  }

  TALUS_HD Point point(int i) const { return {in.x_m[i], in.y_m[i], in.z_m[i]}; }

 private:
  TALUS_HD void put(int i, const Point& sensed, const Point& p, bool kept) const
  {
    const Verdict verdict = accept(sensed, *config);
    int code = select((verdict.seen != 0) & !kept, kVoxel, verdict.code);
    put_ray(i, p, (verdict.seen != 0) & kept);
    const float n = static_cast<float>(config->cells);
    const float cx = p.x_m * config->inverse_resolution, cy = p.y_m * config->inverse_resolution;
    const bool inside = (cx >= 0.0f) & (cx < n) & (cy >= 0.0f) & (cy < n);
    code = select((code == kAccepted) & !inside, kOutside, code);
    const int ix = floor_to_int(select(inside, cx, 0.0f));
    const int iy = floor_to_int(select(inside, cy, 0.0f));
    const int cell = storage_index(*frame, config->cells, ix, iy);
    out.cell[i] = select(code == kAccepted, cell, -1);
    out.rank[i] = static_cast<std::uint32_t>(code);
    out.height_m[i] = p.z_m;
    out.variance_m2[i] = point_variance(sensed.x_m, sensed.y_m, sensed.z_m, *config, *frame);
  }

  TALUS_HD void put_ray(int i, const Point& p, bool seen) const
  {
    const float dx = select(seen, p.x_m - frame->sensor_x_m, 0.0f);
    const float dy = select(seen, p.y_m - frame->sensor_y_m, 0.0f);
    const float chebyshev_m = chebyshev(dx, dy);
    const float ring = chebyshev_m * config->inverse_resolution;
    const bool aims = ring >= 1.0f;  // else straight above or below: no direction
    const int last_ring = ring_count(*config) - 1;
    const float farthest = static_cast<float>(last_ring);
    const int row = floor_to_int(select(ring > farthest, farthest, ring));
    const int bins = bin_count(*config);
    const float direction =
        direction_in_bins(select(aims, dx, 1.0f), select(aims, dy, 0.0f), bins_per_side(*config));
    const int bin = wrap_bin(floor_to_int(direction), bins);
    out.ray[i] = select(aims, row * bins + bin, -1);
    out.slope[i] = ray_slope(p.z_m - frame->sensor_z_m, chebyshev_m);
  }
};

/** The same, and counts the point in its cell, also if it will turn out to be buried. The point
 * itself is there before the frame's context is. */
template <class Atomics>
struct AcceptAndCountPoint
{
  AcceptPoint<Atomics> accept;
  std::uint32_t* cell_count;  //!< by storage index, zero before

  TALUS_HD Point early(int i) const { return accept.point(i); }
  TALUS_HD void operator()(int i, const Point& sensed) const
  {
    if (i >= accept.frame->n_points) return;
    accept.locate(i, sensed);
    accept.note(i);
    if (accept.out.cell[i] < 0) return;
    accept.out.rank[i] = Atomics::add(cell_count + accept.out.cell[i], 1);
  }
};

// ---- Rays under the ground ----

// Mirrors and wet cars send points back from below the ground. Such a ray would have passed under
// ground that the same scan sees in the same direction, nearer, where the map has ground too.

/** A hit is on known ground if it is this near to it; a ray is buried if it passes this far below.
 */
constexpr float kOnGround_m = 0.1f, kBuried_m = 0.2f;

/** For a hit in one place of the table: the slope that a ray must keep to pass over known ground
 * that was hit there; -infinity where none was. */
struct FindGroundHits
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;

  /** Where the cell of a place of the table is stored, or -1: the map has no ground there. */
  TALUS_HD int cell_at(const BinDirection& d, int ring) const
  {
    const int n = config->cells;
    const float scale = config->inverse_resolution, chebyshev_m = distance_m(ring);
    const int ix = floor_to_int((frame->sensor_x_m + d.x * chebyshev_m) * scale);
    const int iy = floor_to_int((frame->sensor_y_m + d.y * chebyshev_m) * scale);
    const bool inside =
        (ring > 0) & (ring < ring_count(*config) - 1) & (ix >= 0) & (iy >= 0) & (ix < n) & (iy < n);
    const bool known = inside & !entered_window(*frame, n, ix, iy);
    return select(known, storage_index(*frame, n, ix, iy), -1);
  }
  /** The limit from what that cell holds. */
  TALUS_HD float limit(int ring, std::int32_t hit, int state, float ground_m) const
  {
    const float slope = float_from_ordered(hit);
    const float height = frame->sensor_z_m + slope * distance_m(ring);
    const bool on_ground = (state == kMeasured) & (abs_of(height - ground_m) < kOnGround_m);
    return select(on_ground, slope - margin(ring), -kInfinity);
  }
  /** How much lower than a hit the limit is that it may set. */
  TALUS_HD float margin(int ring) const { return kBuried_m / distance_m(ring); }

 private:
  TALUS_HD float distance_m(int ring) const
  {
    return (static_cast<float>(ring) + 0.5f) * config->resolution_m;
  }
};

/** What a direction has seen so far, from the sensor outwards. It follows the second highest limit,
 * so that one wrong cell does not blind it. */
struct BuriedBelow
{
  float highest = -kInfinity, second = -kInfinity;

  /** Takes the next hit and the limit that it sets; true if the hit is buried itself. */
  TALUS_HD bool meet(std::int32_t hit, float limit)
  {
    if (float_from_ordered(hit) < second) return true;
    add(limit);
    return false;
  }
  /** The limit of a buried hit is below the second highest: it need not be left out. */
  TALUS_HD void add(float limit)
  {
    second = max_of(second, min_of(highest, limit));
    highest = max_of(highest, limit);
  }
  /** What another stretch of the direction has seen. */
  TALUS_HD void add(const BuriedBelow& other)
  {
    second = max_of(max_of(second, other.second), min_of(highest, other.highest));
    highest = max_of(highest, other.highest);
  }
};

/** The lowest hit of a stretch of a direction. */
struct LowestHit
{
  std::int32_t slope = kNoRay;

  TALUS_HD void add(std::int32_t hit) { slope = min_of(slope, hit); }
  TALUS_HD void add(const LowestHit& other) { add(other.slope); }
};

/** The rays of one direction, for executors that cut it into stretches: removes the buried ones,
 * then replaces each ring's lowest hit by the lowest ray that went at least that far. Each step
 * takes a stretch and what the stretches before it, or behind it, have seen. */
struct SettleRays
{
  using Before = BuriedBelow;
  using Behind = LowestHit;
  FindGroundHits ground;
  std::int32_t* rays;
  float* lowest_slope;  //!< of a ray that is not buried, where there is a hit; same layout as rays

  /** First step: of the rings [begin, end), outwards. */
  TALUS_HD void look(int bin, int begin, int end, BuriedBelow& seen) const
  {
    for (int ring = begin; ring < end; ring += kBatch)
    {
      std::int32_t hits[kBatch];
      load(bin, ring, end, hits);
      float limits[kBatch];
      find_limits(bin, ring, hits, limits);
      for (int b = 0; b < kBatch; b++)
      {
        if (hits[b] != kNoRay) lowest_slope[place(bin, ring + b)] = limits[b];
        seen.add(limits[b]);
      }
    }
  }
  /** Second step, outwards. */
  TALUS_HD void bury(int bin, int begin, int end, BuriedBelow& seen, LowestHit& lowest) const
  {
    for (int ring = begin; ring < end; ring += kBatch)
    {
      std::int32_t hits[kBatch];
      load(bin, ring, end, hits);
      float limits[kBatch];
      for (int b = 0; b < kBatch; b++)
        limits[b] = hits[b] != kNoRay ? lowest_slope[place(bin, ring + b)] : -kInfinity;
      for (int b = 0; b < kBatch; b++)
      {
        if (hits[b] == kNoRay) continue;
        const int r = place(bin, ring + b);
        lowest_slope[r] = seen.second;
        if (seen.meet(hits[b], limits[b]))
          rays[r] = kNoRay;
        else
          lowest.add(hits[b]);
      }
    }
  }
  /** Third step, inwards. */
  TALUS_HD void sweep(int bin, int begin, int end, LowestHit& lowest) const
  {
    for (int ring = begin + (end - begin - 1) / kBatch * kBatch; ring >= begin; ring -= kBatch)
    {
      std::int32_t hits[kBatch];
      load(bin, ring, end, hits);
      for (int b = kBatch - 1; b >= 0; b--)
      {
        lowest.add(hits[b]);
        if (ring + b < end) rays[place(bin, ring + b)] = lowest.slope;
      }
    }
  }

 private:
  static constexpr int kBatch = 8;

  // Loads first, so that they do not wait for each other.

  TALUS_HD void find_limits(int bin, int ring, const std::int32_t* hits, float* limits) const
  {
    const BinDirection d = direction_of_bin(bin, bins_per_side(*ground.config));
    float ground_m[kBatch];
    int state[kBatch];
    for (int b = 0; b < kBatch; b++)
    {
      const int i = hits[b] != kNoRay ? ground.cell_at(d, ring + b) : -1;
      state[b] = i >= 0 ? static_cast<int>(ground.store.state[i]) : static_cast<int>(kUnknown);
      ground_m[b] = i >= 0 ? ground.store.ground_m[i] : 0.0f;
    }
    for (int b = 0; b < kBatch; b++)
      limits[b] = ground.limit(ring + b, hits[b], state[b], ground_m[b]);
  }
  TALUS_HD void load(int bin, int ring, int end, std::int32_t* hits) const
  {
    for (int b = 0; b < kBatch; b++) hits[b] = ring + b < end ? rays[place(bin, ring + b)] : kNoRay;
  }
  TALUS_HD int place(int bin, int ring) const { return ring * bin_count(*ground.config) + bin; }
};

/** The same of some directions ring by ring, for executors that have few threads. No limits are
 * looked for in directions in which no ray could be buried, wherever known ground is. */
struct SweepRays
{
  FindGroundHits ground;
  std::int32_t* rays;
  float* lowest_slope;  //!< as SettleRays leaves it; -infinity in directions without doubt
  std::uint8_t* doubted;  //!< by direction, of the last frame before

  void operator()(int first_bin, int last_bin) const
  {
    // Copies that nothing else can write to, so that loops need not read them again.
    const Config config = *ground.config;
    const FrameContext frame = *ground.frame;
    SweepRays here = *this;
    here.ground.config = &config, here.ground.frame = &frame;
    for (int bin = first_bin; bin < last_bin; bin += kBlock)
      here.sweep(bin, min_of(kBlock, last_bin - bin));
  }

 private:
  static constexpr int kBlock = 256, kGroup = 32;

  /** Directions on the way outwards. */
  struct Directions
  {
    BuriedBelow seen[kBlock];
    float x[kBlock], y[kBlock];
  };

  int rings() const { return ring_count(*ground.config); }
  int place(int ring, int bin) const { return ring * bin_count(*ground.config) + bin; }

  void sweep(int first_bin, int bins) const
  {
    forget(first_bin, bins);
    if (find_doubted(first_bin, bins)) bury(first_bin, bins);
    for (int ring = rings() - 2; ring >= 0; ring--)
    {
      std::int32_t* const row = rays + place(ring, first_bin);
      const std::int32_t* const next = rays + place(ring + 1, first_bin);
      for (int b = 0; b < bins; b++) row[b] = min_of(row[b], next[b]);
    }
  }
  void bury(int first_bin, int bins) const
  {
    Directions d;
    for (int b = 0; b < bins; b++)
    {
      const BinDirection vector = direction_of_bin(first_bin + b, bins_per_side(*ground.config));
      d.seen[b] = {}, d.x[b] = vector.x, d.y[b] = vector.y;
    }
    for (int ring = 0; ring < rings(); ring++)
    {
      const int first = place(ring, first_bin);
      bury_ring(d, ring, rays + first, lowest_slope + first, doubted + first_bin, bins);
    }
  }
  /** What the last frame left. */
  void forget(int first_bin, int bins) const
  {
    for (int bin = first_bin; bin < first_bin + bins; bin++)
      for (int ring = 0; doubted[bin] && ring < rings(); ring++)
        lowest_slope[place(ring, bin)] = -kInfinity;
  }
  /** Finds the directions in which a ray would be buried if all hits were on known ground. */
  int find_doubted(int first_bin, int bins) const
  {
    float highest[kBlock], second[kBlock];
    std::int32_t doubt[kBlock];
    for (int b = 0; b < bins; b++) highest[b] = second[b] = -kInfinity, doubt[b] = 0;
    for (int ring = 0; ring < rings(); ring++)
    {
      const std::int32_t* const row = rays + place(ring, first_bin);
      const float margin = ground.margin(ring);
      for (int b = 0; b < bins; b++)
      {
        const bool hit = row[b] != kNoRay;
        const float slope = select(hit, float_from_ordered(row[b]), kInfinity);
        doubt[b] |= select(slope < second[b], 1, 0);
        const float limit = select(hit, slope - margin, -kInfinity);
        second[b] = max_of(second[b], min_of(highest[b], limit));
        highest[b] = max_of(highest[b], limit);
      }
    }
    int any = 0;
    for (int b = 0; b < bins; b++) any |= doubt[b];
    for (int b = 0; b < bins; b++) doubted[first_bin + b] = static_cast<std::uint8_t>(doubt[b]);
    return any;
  }
  void bury_ring(
      Directions& d, int ring, std::int32_t* row, float* slope, const std::uint8_t* doubt,
      int bins) const
  {
    int bin[kBlock];
    float limit[kBlock];
    const int hits = list_hits(row, doubt, bins, bin);
    find_limits(d, row, ring, bin, (hits + kGroup - 1) / kGroup * kGroup, limit);
    for (int h = 0; h < hits; h++)
    {
      const int b = bin[h];
      slope[b] = d.seen[b].second;
      if (d.seen[b].meet(row[b], limit[h])) row[b] = kNoRay;
    }
  }
  /** Lists the hits in doubted directions, since whether a place holds one cannot be guessed; the
   * last group of the list is filled up with any bin. */
  static int list_hits(const std::int32_t* row, const std::uint8_t* doubt, int bins, int* bin)
  {
    int hits = 0;
    for (int first = 0; first < bins; first += kGroup)
    {
      const int last = min_of(first + kGroup, bins);
      int any = 0;
      for (int b = first; b < last; b++) any |= (row[b] != kNoRay) & doubt[b];
      if (!any) continue;
      for (int b = first; b < last; b++)
      {
        bin[hits] = b;
        hits += (row[b] != kNoRay) & doubt[b];
      }
    }
    for (int h = hits; h % kGroup; h++) bin[h] = 0;
    return hits;
  }
  /** In loops that become vector code, but for the loads of the states, which are bytes. */
  void find_limits(
      const Directions& d, const std::int32_t* row, int ring, const int* bin, int hits,
      float* limit) const
  {
    int cell[kBlock], state[kBlock];
    for (int h = 0; h < hits; h++) cell[h] = ground.cell_at({d.x[bin[h]], d.y[bin[h]]}, ring);
    for (int h = 0; h < hits; h++)
    {
      const int i = max_of(cell[h], 0);
      state[h] = select(cell[h] < 0, kUnknown, ground.store.state[i]);
      limit[h] = ground.store.ground_m[i];
    }
    for (int h = 0; h < hits; h++) limit[h] = ground.limit(ring, row[bin[h]], state[h], limit[h]);
  }
};

/** Bins one point, if it is not buried, in a cell that no other thread has to do with. */
template <class Atomics>
struct BinPoint
{
  const Config* config;
  const FrameContext* frame;
  PointsOut points;
  const float* lowest_slope;
  std::uint32_t* cell_count;  //!< by storage index, zero before
  std::uint32_t* rejected;  //!< by RejectCode

  /** Of the window's cells, as they are stored; may go on at the beginning. */
  Part part(int which, int of) const
  {
    const int n = config->cells, first = which * n / of, end = (which + 1) * n / of;
    const int begin = storage_index(*frame, n, 0, first) - frame->storage_x;
    return {begin, begin + (end - first) * n};
  }
  bool is_in(const Part& part, int i) const
  {
    const int n = config->cells, cell = points.cell[i];
    const int place = cell + select(cell < part.begin, n * n, 0);
    return (cell >= 0) & (place < part.end);
  }
  void operator()(int i) const
  {
    const int cell = points.cell[i];
    if (cell < 0) return;
    const int ray = points.ray[i];
    const bool buried = ray >= 0 && points.slope[i] < lowest_slope[ray];
    if (buried) Atomics::count(rejected + kBuried);
    points.rank[i] = buried ? kNoRank : cell_count[cell]++;
  }
};

// ---- Optional voxel filter ----

// One point a voxel. Which one must not depend on the order of the points: the one whose
// coordinates mix to the smallest number. Two passes over an open-addressing table of voxels.

constexpr std::uint64_t kNoVoxel = ~0ull;

TALUS_HD std::uint64_t mix_bits(std::uint64_t v)
{
  v ^= v >> 30;
  v *= 0xbf58476d1ce4e5b9ull;
  v ^= v >> 27;
  v *= 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}

struct VoxelTable
{
  std::uint64_t* key;  //!< kNoVoxel before
  std::uint64_t* winner;  //!< kNoVoxel before
  std::uint32_t mask;  //!< size - 1, a power of two at least twice the points
};

/** Enters one point into the table; `slot` remembers where. */
template <class Atomics>
struct EnterVoxel
{
  const Config* config;
  const FrameContext* frame;
  PointsIn in;
  VoxelTable table;
  std::uint32_t* slot;

  TALUS_HD void operator()(int i) const
  {
    if (i >= frame->n_points) return;
    const Point p{in.x_m[i], in.y_m[i], in.z_m[i]};
    if (accept(p, *config).code != kAccepted) return;
    const std::uint64_t key = voxel_key(p);
    std::uint32_t s = static_cast<std::uint32_t>(mix_bits(key)) & table.mask;
    for (;;)
    {
      const std::uint64_t there = Atomics::compare_exchange(table.key + s, kNoVoxel, key);
      if (there == kNoVoxel || there == key) break;
      s = (s + 1) & table.mask;
    }
    slot[i] = s;
    Atomics::min(table.winner + s, fingerprint(p));
  }

  /** 21 bits a coordinate, sensor frame. */
  TALUS_HD std::uint64_t voxel_key(const Point& p) const
  {
    constexpr std::uint64_t mask = (1u << 21) - 1;
    const auto part = [&](float v)
    { return static_cast<std::uint64_t>(floor_to_int(v * config->inverse_voxel)) & mask; };
    return part(p.x_m) << 42 | part(p.y_m) << 21 | part(p.z_m);
  }

  static TALUS_HD std::uint64_t fingerprint(const Point& p)
  {
    const auto bits = [](float v)
    { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(ordered_from_float(v))); };
    return mix_bits(mix_bits(bits(p.x_m) << 32 | bits(p.y_m)) ^ bits(p.z_m));
  }
};

/** Keeps the points that stand for their voxel. */
template <class Atomics>
struct KeepVoxel
{
  EnterVoxel<Atomics> entered;
  std::uint8_t* kept;

  TALUS_HD void operator()(int i) const
  {
    if (i >= entered.frame->n_points) return;
    const Point p{entered.in.x_m[i], entered.in.y_m[i], entered.in.z_m[i]};
    kept[i] = accept(p, *entered.config).code != kAccepted ||
              entered.table.winner[entered.slot[i]] == EnterVoxel<Atomics>::fingerprint(p);
  }
};

}  // namespace talus::kernels
