#include "cell_hits.h"

#include <algorithm>
#include <cmath>

namespace talus::baselines
{
namespace
{
/** What stands so high stops a robot, and what is higher hangs over it. */
constexpr float kLowest_m = 0.3f, kHighest_m = 1.8f;
constexpr int kMovesFrames = 20;  //!< from so many frames on it stands
/** Frames with ground alone after which what stood there has left; and before or after which it
 * stood there for a moment. */
constexpr int kLeftFrames = 5, kBareFrames = 2;
/** Of the cells so near in which something stood, so many have to be bare before or after. */
constexpr double kNear_m = 0.3, kMostOfThem = 0.8;
}  // namespace

CellHits::CellHits(const Sequence& sequence, const Parameters& p)
    : resolution_m_(p.resolution_m), near_cells_(std::llround(kNear_m / p.resolution_m))
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

bool CellHits::has_left(std::int64_t x, std::int64_t y) const
{
  const Hits* const h = find({x, y});
  return h && h->stood_for_a_moment() && h->bare_after >= kLeftFrames;
}

bool CellHits::was_swept(std::int64_t x, std::int64_t y) const
{
  const Hits* const here = find({x, y});
  if (!here || !here->stood_on_bare_ground()) return false;
  Share bare;
  for (std::int64_t dy = -near_cells_; dy <= near_cells_; ++dy)
    for (std::int64_t dx = -near_cells_; dx <= near_cells_; ++dx)
    {
      const Hits* const near = find({x + dx, y + dy});
      if (near && near->up_frames > 0) bare.add(near->stood_on_bare_ground());
    }
  return bare.value() >= kMostOfThem;
}

bool CellHits::Hits::stood_for_a_moment() const
{
  return up_frames > 0 && up_frames < kMovesFrames;
}

bool CellHits::Hits::stood_on_bare_ground() const
{
  return stood_for_a_moment() && std::max(bare_before, bare_after) >= kBareFrames &&
         bare_before + bare_after >= up_frames;
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
    h.up_frames += stands;
    h.bare_after = stands ? 0 : h.bare_after + 1;
    if (h.up_frames == 0) h.bare_before = h.bare_after;
  }
}

}  // namespace talus::baselines
