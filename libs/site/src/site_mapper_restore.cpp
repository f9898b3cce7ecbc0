#include <talus/site/site_mapper.h>

#include "kept_cell.h"
#include "strips.h"

#include <algorithm>
#include <cmath>

// What comes back into the window is restored.
namespace talus::site
{
namespace
{
/** Away from the robot, where no ground is known beside a cell, it may rise or fall so much more
 * [m/m]. */
constexpr float kRise = 0.25f;
/** What comes back is off by so much as a whole where the poses have drifted: then it is not
 * restored. More where there is only what lies beside it to compare with: there may be a kerb
 * between, or a slope [m/m]. */
constexpr float kDrifted_m = 0.05f, kDriftedBeside_m = 0.15f, kSlope = 0.7f;
/** Fewer cells that were measured then and now say nothing. */
constexpr std::size_t kMinSame = 3;
/** So long are the stretches of a strip that are restored or not. */
constexpr int kStretch_cells = 32;

std::size_t stretch_of(const CellRect& cells, std::size_t i)
{
  const auto width = static_cast<std::size_t>(cells.width_cells);
  const bool is_upright = cells.height_cells >= cells.width_cells;
  return (is_upright ? i / width : i % width) / kStretch_cells;
}

/** NaN of none. */
float median(std::vector<float>& values)
{
  if (values.empty()) return NAN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/** The gaps of a line take what is nearest. */
void fill_gaps(std::vector<float>& line)
{
  const std::size_t n = line.size();
  std::size_t gap = 0;  // where the last known one ends
  for (std::size_t i = 0; i <= n; ++i)
  {
    if (i < n && std::isnan(line[i])) continue;
    const std::size_t begin = gap, middle = (begin + i) / 2;
    const float before = begin > 0 ? line[begin - 1] : NAN, after = i < n ? line[i] : NAN;
    for (; gap < i; ++gap)
      line[gap] = std::isnan(after) || (gap < middle && !std::isnan(before)) ? before : after;
    gap = i + 1;
  }
}
}  // namespace

/** Whether anything was kept near some cells, on any floor. */
bool SiteMapper::was_here(const CellRect& cells) const
{
  bool any = false;
  for (int floor = 0; floor < state_.floors && !any; ++floor)
    for_each_tile(cells, floor, [&](const TilePart& part) { any |= site_.tiles.has(part.key); });
  return any;
}

/** Asks for cells that come into the window with the next frame, where any may be given back. */
void SiteMapper::ask_for_entered(const Window& before, const Window& after)
{
  if (!restores_ || state_.choice != Choice::None || is_same_window(before, after)) return;
  const Strip x = Strip::beside_x(after, before), y = Strip::beside_y(after, before);
  if (was_here(x.cells) || was_here(y.cells))
    with_frame_.after = {x.cells, y.cells, x.beside, y.beside};
}

/** Gives back what was kept of cells that have come into the window. */
void SiteMapper::restore_entered(ElevationMapper& map, const Window& before, const Window& after)
{
  const Strip x = Strip::beside_x(after, before), y = Strip::beside_y(after, before);
  const std::size_t cells = x.cells.size() + y.cells.size();
  take_up(map, with_frame_.records_after, after);
  refer_to_beside(x, 0, cells);
  refer_to_beside(y, x.cells.size(), cells + x.beside.size());
  const bool any_x = take_back(x.cells, 0), any_y = take_back(y.cells, x.cells.size());
  if (!any_x && !any_y) return;
  rects_ = {x.cells, y.cells};
  write_back(map, cells);
}

/** Gives back the first of the records, which are those of `rects_`. */
void SiteMapper::write_back(ElevationMapper& map, std::size_t cells)
{
  map.write_cells(rects_, records_.first, cells);
  if (given_back_.empty()) return;
  given_back_.resize(cells);
  map.write_channels(rects_, given_back_.data(), cells);
  given_back_.clear();
}

/** Puts what was kept of cells in the place of their records where it is worth more, and nothing
 * elsewhere. Whether there is any. */
bool SiteMapper::take_back(const CellRect& cells, std::size_t first)
{
  const Votes here = votes(state_.floor, cells, first);
  if (here.agree > 0 && here.agree >= here.contradict)
    return take_back_from(state_.floor, cells, first);
  return take_back_from(other_floor(cells, first, 1).value_or(state_.floor), cells, first);
}

/** Finds the stretches of a strip where what was measured on a floor is off the ground of now as a
 * whole: that of the same cells, or of those beside them, where it may lie on a slope. */
void SiteMapper::find_drifted(int floor, const CellRect& cells, std::size_t first)
{
  const int length = std::max(cells.width_cells, cells.height_cells);
  const int width = std::min(cells.width_cells, cells.height_cells);
  stretches_.resize(
      std::max(stretches_.size(), static_cast<std::size_t>(length / kStretch_cells + 1)));
  for (Stretch& s : stretches_)
    for (auto* off_m : {&s.off_m, &s.off_beside_m})
    {
      off_m->clear();
      off_m->reserve(static_cast<std::size_t>(kStretch_cells * width));
    }
  const auto compare = [&](std::size_t i, const CellRecord& kept)
  {
    const Reference& r = references_[first + i];
    const float off_m = kept.ground_m - r.ground_m;
    if (!is_measured(kept) || !(std::abs(off_m) <= r.within_m)) return;
    Stretch& s = stretches_[stretch_of(cells, i)];
    (is_measured(records_[first + i]) ? s.off_m : s.off_beside_m).push_back(off_m);
  };
  for_each_kept_cell(site_.tiles, cells, floor, compare);
  const float width_m = static_cast<float>(site_.resolution_m) * static_cast<float>(width);
  for (Stretch& s : stretches_)
    s.has_drifted = s.off_m.size() >= kMinSame
                        ? std::abs(median(s.off_m)) > kDrifted_m
                        : std::abs(median(s.off_beside_m)) > kDriftedBeside_m + kSlope * width_m;
}

bool SiteMapper::take_back_from(int floor, const CellRect& cells, std::size_t first)
{
  bool any = false;
  find_drifted(floor, cells, first);
  const auto look_up = [&](const TilePart& part)
  {
    const Tile* tile = site_.tiles.find(part.key);
    const ChannelTile* values =
        channel_places_.empty() ? nullptr : site_.channel_tiles.find(part.key);
    for_each_cell(
        cells, part,
        [&](std::size_t i, std::size_t at)
        {
          CellRecord& now = records_[first + i];
          const CellRecord kept = tile ? tile->cells[at].cell : CellRecord{};
          const Reference& r = references_[first + i];
          const bool is_better = is_worth_more(kept, now);
          const bool fits = (is_better || values) &&
                            !(std::abs(kept.ground_m - r.ground_m) > r.within_m) &&
                            !stretches_[stretch_of(cells, i)].has_drifted;
          const bool takes = is_better && fits;
          if (values && fits && is_known(kept))
            any |= take_back_channels(first + i, values->cells[at], takes);
          now = takes ? kept : CellRecord{};
          any |= takes;
        });
  };
  for_each_tile(cells, floor, look_up);
  return any;
}

/** Where the map measured the ground itself, what stood there is not known to stand. */
bool SiteMapper::take_back_channels(std::size_t i, const ChannelRecord& kept, bool takes_all)
{
  if (given_back_.size() <= i) given_back_.resize(i + 1);
  bool any = false;
  for (std::size_t l = 0; l < channel_places_.size(); l += takes_all ? 1 : kChannelSurfaces)
  {
    given_back_[i].values[l] = kept.values[channel_places_[l]];
    any |= !std::isnan(given_back_[i].values[l]);
  }
  return any;
}

/** Where nothing was measured, they go on from what is known beside them. */
void SiteMapper::refer_to_beside(const Strip& strip, std::size_t first, std::size_t first_beside)
{
  beside_m_.resize(strip.beside.size());
  for (std::size_t i = 0; i < beside_m_.size(); ++i)
    beside_m_[i] = records_[first_beside + i].ground_m;
  fill_gaps(beside_m_);
  const int width = strip.cells.width_cells;
  for (std::size_t i = 0; i < strip.cells.size(); ++i)
  {
    Reference& r = references_[first + i];
    if (!std::isnan(r.ground_m)) continue;
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    r.ground_m = beside_m_[static_cast<std::size_t>(strip.is_upright ? y : x)];
    if (!std::isnan(r.ground_m)) continue;
    const double x_m = site_.resolution_m * static_cast<double>(strip.cells.min_cell_x + x);
    const double y_m = site_.resolution_m * static_cast<double>(strip.cells.min_cell_y + y);
    r.ground_m = static_cast<float>(state_.base.z_m);
    r.within_m +=
        kRise * static_cast<float>(std::hypot(x_m - state_.base.x_m, y_m - state_.base.y_m));
  }
}

}  // namespace talus::site
