#include "cell_hits.h"

#include <algorithm>
#include <cmath>

namespace talus::baselines
{
namespace
{
/** What stands so high stops a robot, and what is higher hangs over it. */
constexpr float kLowest_m = 0.3f, kHighest_m = 1.8f;
constexpr int kLeftFrames = 5;  //!< with ground alone, after which what stood there has left
}  // namespace

CellHits::CellHits(const Sequence& sequence, const Parameters& p) : resolution_m_(p.resolution_m)
{
  for (const ScanFrame& frame : sequence.frames)
    for (const MapPoint& point : accepted_points(frame.view(), p))
    {
      Hits& h = hits_[key(point.x_m, point.y_m)];
      h.lowest_m = std::min(h.lowest_m, point.z_m);
      h.highest_m = std::max(h.highest_m, point.z_m);
    }
  for (const ScanFrame& frame : sequence.frames) add(accepted_points(frame.view(), p));
}

float CellHits::highest_m(double x_m, double y_m) const
{
  const Hits* const h = find(key(x_m, y_m));
  return h ? h->highest_m : Hits{}.highest_m;
}

bool CellHits::has_left(double x_m, double y_m) const
{
  const Hits* const h = find(key(x_m, y_m));
  return h && h->stood && h->bare_after >= kLeftFrames;
}

CellHits::Key CellHits::key(double x_m, double y_m) const
{
  const auto cell = [&](double at_m)
  { return static_cast<std::int64_t>(std::floor(at_m / resolution_m_)); };
  return {cell(x_m), cell(y_m)};
}

const CellHits::Hits* CellHits::find(const Key& cell) const
{
  const auto found = hits_.find(cell);
  return found == hits_.end() ? nullptr : &found->second;
}

void CellHits::add(const std::vector<MapPoint>& points)
{
  std::map<Key, bool> up;
  for (const MapPoint& p : points)
  {
    const float above_m = p.z_m - hits_[key(p.x_m, p.y_m)].lowest_m;
    up[key(p.x_m, p.y_m)] |= above_m >= kLowest_m && above_m <= kHighest_m;
  }
  for (const auto& [cell, stands] : up)
  {
    Hits& h = hits_[cell];
    h.stood |= stands;
    h.bare_after = stands ? 0 : h.bare_after + 1;
  }
}

}  // namespace talus::baselines
