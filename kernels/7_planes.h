#pragma once
#include "kernels/6_cleanup.h"
#include "kernels/group.h"

#include <initializer_list>

namespace talus::kernels
{
// Stage 7, before the lines: what the samples of the whole window say of ground that was not
// measured. Two planes: how the ground rises, for fills that have samples on one side only, and the
// floor, if there is one, on which fills that come near it lie.

/** Places of the window on a grid with the sensor's cell in its very middle: one more row and
 * column than the window where its cells are even in number. */
struct LineGrid
{
  int half, side, pitch;

  TALUS_HD int at(int ix, int iy) const { return iy * pitch + ix; }
  TALUS_HD int middle() const { return at(half, half); }
};

/** The pitch is an odd number of cache lines, so that the places of a column do not fight for the
 * same part of a cache. */
TALUS_HD LineGrid line_grid(const Config& k)
{
  const int half = k.cells / 2, side = 2 * half + 1;
  return {half, side, (side + 31) / 32 * 32 + 16};
}

/** How the ground around the robot rises, metres per metre along x and y of the map. The less a
 * plane fits it, the more level it is taken to be: a bank beside a floor says nothing about the
 * floor. */
struct Trend
{
  float x = 0, y = 0;

  TALUS_HD float along(const Direction& d) const { return x * d.x + y * d.y; }
};

/** The floor: the plane on which most samples of the window lie, if they lie on it as closely as
 * floors do. A fill knows from a few samples what the plane knows from all. */
struct Floor
{
  float height_m = 0;  //!< in the middle of cell (0, 0) of the window, map frame
  float x_m = 0, y_m = 0;  //!< how it rises from cell to cell
  float trust = 0;  //!< 0: there is none, to 1

  TALUS_HD float at(int ix, int iy) const
  {
    return height_m + (x_m * static_cast<float>(ix) + y_m * static_cast<float>(iy));
  }
  /** Where a fill lies that lines expect at a height: what is farther off is no floor. */
  TALUS_HD float draw(float expected_m, int ix, int iy) const
  {
    const float off_m = expected_m - at(ix, iy), part = off_m * (1.0f / kNearFloor_m);
    const float square = part * part;
    return expected_m - off_m * (trust / (1.0f + square * square));
  }
};

struct Planes
{
  Trend trend;
  Floor floor;
};

/** From samples at 16 x 16 places: exact sums, so that every group comes to the same planes. Each
 * member keeps its own samples from fit to fit. */
struct FindPlanes
{
  const Config* config;
  const FrameContext* frame;
  LineGrid grid;
  const float* sample_m;
  Planes* planes;

  template <class Group>
  TALUS_HD void operator()(const Group& group) const
  {
    const auto own = samples_of(group);
    Plane plane = fit({}, kInfinity, own, group);
    const Trend trend = trend_of(plane);
    const int all = plane.n;
    for (const float within_m : {kFloorWithin_m, kFloorCloselyWithin_m})
      plane = fit(plane, within_m, own, group);
    if (group.rank() == 0) *planes = {trend, floor_of(plane, all)};
  }

 private:
  /** Steps of heights per metre: finer than those of windows, as its sums have 64 bits. */
  static constexpr float kSteps = 65536.0f;

  /** Heights in such steps, x and y in cells from the middle of the window. */
  struct Plane
  {
    std::int32_t n = 0;  //!< samples; 0: they are too few, or in a line, and it is level
    float height = 0, x = 0, y = 0;
    float rest = 0;  //!< mean squared distance of the samples

    TALUS_HD float at(int dx, int dy) const
    {
      return height + (x * static_cast<float>(dx) + y * static_cast<float>(dy));
    }
  };

  struct Sums
  {
    std::int32_t n = 0, x = 0, y = 0, h = 0;
    std::int64_t xx = 0, xy = 0, yy = 0, xh = 0, yh = 0, hh = 0;

    /** Nothing where it does not count. Without a branch: of that GCC 14 made wrong vector code for
     * AVX-512. */
    TALUS_HD void add(bool counts, int offset_x, int offset_y, std::int32_t any_height)
    {
      const std::int32_t dx = select(counts, offset_x, 0), dy = select(counts, offset_y, 0);
      const std::int32_t height = select(counts, any_height, 0);
      const std::int64_t x_64 = dx, y_64 = dy, height_64 = height;
      n += select(counts, 1, 0), x += dx, y += dy, h += height;
      xx += x_64 * dx, xy += x_64 * dy, yy += y_64 * dy;
      xh += dx * height_64, yh += dy * height_64, hh += height_64 * height_64;
    }
    template <class Group>
    TALUS_HD void join(const Group& group)
    {
      n = group.sum(n), x = group.sum(x), y = group.sum(y), h = group.sum(h);
      xx = group.sum(xx), xy = group.sum(xy), yy = group.sum(yy);
      xh = group.sum(xh), yh = group.sum(yh), hh = group.sum(hh);
    }
    /** n^2 times the covariance of two quantities, from their sums and that of their products. */
    TALUS_HD float covariance(std::int64_t a, std::int64_t b, std::int64_t ab) const
    {
      return static_cast<float>(n * ab - a * b);
    }
  };

  /** Of the places rank, rank + size ... of a whole group. */
  template <int kSamples>
  struct Own
  {
    std::int32_t height[kSamples];  //!< kNone: no sample
  };
  static constexpr std::int32_t kNone = -0x7fffffff;

  template <class Group>
  TALUS_HD auto samples_of(const Group& group) const
  {
    constexpr int kSamples = kPlaneSide * kPlaneSide / Group::kMembers;
    Own<kSamples> own;
    for (int i = 0; i < kSamples; i++)
    {
      const int place = group.rank() + i * Group::kMembers;
      const float height_m = sample_m[grid.at(cell(place % kPlaneSide), cell(place / kPlaneSide))];
      const bool known = is_known(height_m);
      const std::int32_t height =
          quantise_height(select(known, height_m, 0.0f), frame->sensor_z_m, kSteps);
      own.height[i] = select(known, height, kNone);
    }
    return own;
  }

  /** The least-squares plane through the samples that are so near to another. */
  template <int kSamples, class Group>
  TALUS_HD Plane
  fit(const Plane& to, float within_m, const Own<kSamples>& own, const Group& group) const
  {
    const int middle = config->cells / 2;
    Sums sums;
    for (int i = 0; i < kSamples; i++)
    {
      const int place = group.rank() + i * Group::kMembers;
      const int dx = cell(place % kPlaneSide) - middle, dy = cell(place / kPlaneSide) - middle;
      const std::int32_t height = own.height[i];
      const float off = static_cast<float>(height) - to.at(dx, dy);
      sums.add((height != kNone) & (abs_of(off) <= within_m * kSteps), dx, dy, height);
    }
    sums.join(group);
    return sums.n < kFewestSamples ? Plane{} : solve(sums);
  }
  TALUS_HD int cell(int place) const { return (2 * place + 1) * config->cells / (2 * kPlaneSide); }

  TALUS_HD static Plane solve(const Sums& s)
  {
    const float xx = s.covariance(s.x, s.x, s.xx), xy = s.covariance(s.x, s.y, s.xy);
    const float yy = s.covariance(s.y, s.y, s.yy), xh = s.covariance(s.x, s.h, s.xh);
    const float yh = s.covariance(s.y, s.h, s.yh), hh = s.covariance(s.h, s.h, s.hh);
    const float area = xx * yy - xy * xy;
    if (area <= kInALine * xx * yy) return {};  // samples nearly in a line
    const float gx = (xh * yy - yh * xy) / area, gy = (yh * xx - xh * xy) / area;
    const float n = static_cast<float>(s.n);
    const float height =
        (static_cast<float>(s.h) - gx * static_cast<float>(s.x) - gy * static_cast<float>(s.y)) / n;
    return {s.n, height, gx, gy, max_of(hh - gx * xh - gy * yh, 0.0f) / (n * n)};
  }

  TALUS_HD Trend trend_of(const Plane& plane) const
  {
    const float off = kBelieved_steps * config->step_threshold_m * kSteps;
    const float believed = off * off / (off * off + plane.rest);
    const float per_m = config->inverse_resolution / kSteps * believed;
    return {plane.x * per_m, plane.y * per_m};
  }
  /** Trusted by the share of the samples that lie on it, and by how closely. */
  TALUS_HD Floor floor_of(const Plane& plane, int of_samples) const
  {
    if (plane.n == 0 || config->fill_rule != kFillLines) return {};
    constexpr float kMetres = 1.0f / kSteps, kHalf = kFloorRest_m * kSteps;
    const int to_corner = -(config->cells / 2);
    const float height_m = frame->sensor_z_m + plane.at(to_corner, to_corner) * kMetres;
    const float share = static_cast<float>(plane.n) / static_cast<float>(of_samples);
    const float off = plane.rest * (1.0f / (kHalf * kHalf));
    const float trust = share * share / (1.0f + off * off);
    return {height_m, plane.x * kMetres, plane.y * kMetres, trust};
  }
};

}  // namespace talus::kernels
