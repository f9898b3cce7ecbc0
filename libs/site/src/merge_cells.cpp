#include <talus/site/merge.h>

#include "known_cells.h"
#include "kept_cell.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>
#include <vector>

namespace talus::site
{
namespace
{
constexpr double kMinVariance_m2 = 1e-12;  //!< a micrometre: no division by 0

std::uint32_t bits(float v)
{
  std::uint32_t b;
  std::memcpy(&b, &v, sizeof b);
  return b;
}

/** All of a cell, the time first. */
auto key(const SiteCell& s)
{
  const CellRecord& c = s.cell;
  std::array<std::uint8_t, CellRecord::kEvidenceBytes> evidence;
  std::copy_n(c.evidence, evidence.size(), evidence.begin());
  return std::make_tuple(
      s.seen_s, bits(c.ground_m), bits(c.ground_variance_m2), bits(c.elevation_m),
      bits(c.elevation_variance_m2), bits(c.traversability), c.state, evidence);
}
bool is_newer(const SiteCell& a, const SiteCell& b) { return key(a) > key(b); }
bool is_same(const SiteCell& a, const SiteCell& b) { return key(a) == key(b); }

/** The mean of heights by information. Where they lie farther apart than their variances allow, one
 * more variance is added to each, by the method of moments of DerSimonian and Laird: the variance
 * of the mean then includes it. */
class Mean
{
 public:
  void add(float height_m, float variance_m2)
  {
    heights_.emplace_back(height_m, std::max<double>(variance_m2, kMinVariance_m2));
  }
  std::size_t count() const { return heights_.size(); }
  /** Of more than one. */
  void put(float& height_m, float& variance_m2) const
  {
    Sums s = sums(0);
    s = sums(between_m2(s));
    height_m = static_cast<float>(s.height / s.information);
    variance_m2 = static_cast<float>(1 / s.information);
  }

 private:
  struct Sums
  {
    double information = 0, squared = 0, height = 0;
  };
  Sums sums(double between) const
  {
    Sums s;
    for (const auto& [height_m, variance_m2] : heights_)
    {
      const double information = 1 / (variance_m2 + between);
      s.information += information;
      s.squared += information * information;
      s.height += information * height_m;
    }
    return s;
  }
  /** The variance between the maps, beyond that of each. */
  double between_m2(const Sums& s) const
  {
    const double mean_m = s.height / s.information;
    double spread = 0;
    for (const auto& [height_m, variance_m2] : heights_)
      spread += (height_m - mean_m) * (height_m - mean_m) / variance_m2;
    const double excess = spread - static_cast<double>(heights_.size() - 1);
    return excess > 0 ? excess / (s.information - s.squared / s.information) : 0;
  }

  std::vector<std::pair<double, double>> heights_;  //!< with the variance of each
};

void fuse_ground(
    const std::vector<SiteCell>& cells, const SiteCell& base, double step_m, CellRecord& to)
{
  Mean mean;
  for (const SiteCell& s : cells)
    if (s.cell.state == base.cell.state &&
        std::abs(static_cast<double>(s.cell.ground_m) - base.cell.ground_m) <= step_m)
      mean.add(s.cell.ground_m, s.cell.ground_variance_m2);
  to.state = base.cell.state;
  to.ground_m = base.cell.ground_m;
  to.ground_variance_m2 = base.cell.ground_variance_m2;
  if (mean.count() > 1) mean.put(to.ground_m, to.ground_variance_m2);
}

void fuse_elevation(
    const std::vector<SiteCell>& cells, const SiteCell& base, double step_m, CellRecord& to)
{
  Mean mean;
  for (const SiteCell& s : cells)
    if (std::abs(static_cast<double>(s.cell.elevation_m) - base.cell.elevation_m) <= step_m)
      mean.add(s.cell.elevation_m, s.cell.elevation_variance_m2);
  to.elevation_m = base.cell.elevation_m;
  to.elevation_variance_m2 = base.cell.elevation_variance_m2;
  if (mean.count() > 1) mean.put(to.elevation_m, to.elevation_variance_m2);
}
}  // namespace

SiteCell merge_cells(const SiteCell* cells, int count, double step_m)
{
  std::vector<SiteCell> known;
  known.reserve(static_cast<std::size_t>(count));
  std::copy_if(
      cells, cells + count, std::back_inserter(known), [](const SiteCell& s) { return s.known(); });
  std::sort(known.begin(), known.end(), is_newer);
  known.erase(std::unique(known.begin(), known.end(), is_same), known.end());
  if (known.empty()) return {};
  if (known.size() == 1) return known.front();

  // The first of the best is the newest of them.
  const SiteCell& ground = *std::min_element(
      known.begin(), known.end(),
      [](const SiteCell& a, const SiteCell& b)
      { return guessed_ground(a.cell) < guessed_ground(b.cell); });
  const auto seen = std::find_if(known.begin(), known.end(), has_seen);
  const SiteCell& top = seen == known.end() ? ground : *seen;
  SiteCell merged = top;
  merged.seen_s = std::max(top.seen_s, ground.seen_s);
  fuse_ground(known, ground, step_m, merged.cell);
  if (has_elevation(top)) fuse_elevation(known, top, step_m, merged.cell);
  for (const SiteCell& s : known)
    if (is_reached(s.cell)) set_reached(merged.cell);
  return merged;
}

ChannelRecord merge_values(
    const std::vector<SiteCell>& cells, const std::vector<ChannelRecord>& values)
{
  std::uint32_t newest_s = 0;  // of those that have seen the place
  for (const SiteCell& s : cells)
    if (s.known() && has_seen(s)) newest_s = std::max(newest_s, s.seen_s);
  ChannelRecord merged;
  for (std::size_t l = 0; l < std::size(merged.values); ++l)
  {
    const bool stands = l % kChannelSurfaces != 0;
    std::uint32_t of_s = 0;
    float& best = merged.values[l];
    for (std::size_t i = 0; i < cells.size(); ++i)
    {
      const float v = values[i].values[l];
      const std::uint32_t seen_s = cells[i].seen_s;
      if (!cells[i].known() || std::isnan(v) || (stands && seen_s < newest_s)) continue;
      if (!std::isnan(best) && (seen_s < of_s || (seen_s == of_s && v <= best))) continue;
      best = v;
      of_s = seen_s;
    }
  }
  return merged;
}

}  // namespace talus::site
