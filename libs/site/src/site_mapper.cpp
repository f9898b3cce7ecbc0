#include <talus/site/site_mapper.h>

#include "kept_cell.h"
#include "hindsight.h"
#include "strips.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

namespace talus::site
{
namespace
{
/** Of fewer cells nothing is said about floors. */
constexpr int kMinVotes = 8;
/** A base that has risen or sunk by so much may be on another floor with its next frame. */
constexpr float kRises_m = kOtherFloor_m / 2;
/** A window that was kept so lately is not kept once more when the floor is left: the last frame
 * has put what it saw of the other one into it. */
constexpr double kLately_s = 10;
/** The floor is chosen when the robot has not risen for some frames, or drives. */
constexpr int kFramesCalm = 3;
constexpr double kCalm_m = 0.1, kDrives_m = 0.3;
constexpr double kWayPoint_m = 1;
/** How far around it a cell's traversability is judged by. */
int neighbourhood_cells(const Parameters& p)
{
  return static_cast<int>(std::lround(p.feature_radius_m / p.resolution_m)) + 1;
}

}  // namespace

SiteMapper::SiteMapper(Site& site, bool restores)
    : site_(site), restores_(restores), hindsight_(std::make_unique<Hindsight>())
{
  for (const TileKey& key : site.tiles.keys())
    state_.floors = std::max(state_.floors, key.floor + 1);
  site.ways.emplace_back();
}
SiteMapper::~SiteMapper() = default;

FrameReport SiteMapper::update(
    ElevationMapper& map, const Frame& frame, const std::function<void()>& is_mapped)
{
  const auto start = std::chrono::steady_clock::now();
  take_channels(map);
  FrameReport report = update_kept(map, frame);
  if (is_mapped) is_mapped();
  if (state_.choice == Choice::None)
  {
    hindsight_->add(frame, state_.floor);
    hindsight_->follow(site_, map, state_.base);
  }
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  report.total_ms = took.count();
  return report;
}

void SiteMapper::take_channels(const ElevationMapper& map)
{
  const std::vector<Channel>& channels = map.parameters().channels;
  if (channel_places_.size() == kChannelSurfaces * channels.size()) return;
  add_channels(site_.channels, channels);
  channel_places_ = channel_indices(channels, site_.channels);
}

FrameReport SiteMapper::update_kept(ElevationMapper& map, const Frame& frame)
{
  const Window before = map.window(), after = map.window_after(frame);
  const Pose T_map_base = pose_of_base(frame.T_map_sensor, frame.T_base_sensor);
  const Position base{T_map_base.x(), T_map_base.y(), T_map_base.z()};
  with_frame_.before.clear();
  with_frame_.after.clear();
  if (map.empty())
    begin(base);
  else
  {
    keep_before(map, after, base);
    ask_for_entered(before, after);
    channels_ = map.read_channels(with_frame_.before);
  }
  const auto meanwhile = [&]
  {
    if (!with_frame_.before.empty()) keep_leaving(map, before);
  };
  const FrameReport report = map.update(frame, with_frame_, std::ref(meanwhile));
  state_.stamp_s = frame.stamp_s;
  follow(base);
  if (state_.choice != Choice::None)
    wait_for_floor(map);
  else if (!with_frame_.after.empty())
    restore_entered(map, before, after);
  if (!report.leaves_floor) return report;
  if (state_.choice == Choice::None && !(state_.stamp_s - state_.kept_s < kLately_s)) keep_all(map);
  state_.choice = Choice::LeftFloor;
  state_.calm = base;
  state_.frames_calm = 0;
  return report;
}

void SiteMapper::begin(const Position& base)
{
  state_.calm = base;
  state_.frames_calm = kFramesCalm;
  state_.choice = site_.tiles.keys().empty() ? Choice::None : Choice::Appeared;
}

/** Asks for what leaves with the next frame; keeps all of the window before a frame that may put
 * what it sees of another floor on this one. */
void SiteMapper::keep_before(const ElevationMapper& map, const Window& after, const Position& base)
{
  if (state_.choice != Choice::None) return;
  const Window now = map.window();
  const bool rises = std::abs(base.z_m - state_.calm.z_m) > kRises_m;
  const bool appears = !overlap(now, after);
  if (rises || appears)
  {
    keep_all(map);
    state_.kept_s = state_.stamp_s;
    state_.calm = base;
  }
  else if (!is_same_window(now, after))
  {
    const int edge = neighbourhood_cells(map.parameters());
    const Leaving x(Strip::beside_x(now, after), now, edge);
    const Leaving y(Strip::beside_y(now, after), now, edge);
    with_frame_.before = {x.coming, y.coming, x.edge, y.edge};
  }
  if (!appears) return;
  state_.choice = Choice::Appeared;
  state_.frames_calm = kFramesCalm;
}

/** What comes to the edge is kept as it was while all that it is judged by was in the window, and
 * chooses the floor: at the edge it would agree with itself. */
void SiteMapper::keep_leaving(const ElevationMapper& map, const Window& before)
{
  take_up(map, with_frame_.records_before, before);
  const int floor_before = state_.floor;
  const CellRect *const coming = with_frame_.before.data(), *const edge = coming + 2;
  std::size_t first = 0;
  for (int i = 0; i < 2; ++i)
  {
    keep(coming[i], first);
    first += coming[i].size();
  }
  for (int i = 0; i < 2; ++i)
  {
    if (state_.floor == floor_before) store(edge[i], first);
    first += edge[i].size();
  }
}

void SiteMapper::keep_window(const ElevationMapper& map)
{
  if (map.empty()) return;
  if (state_.choice != Choice::None && choose_floor(map)) state_.choice = Choice::None;
  keep_all(map);
  auto& way = site_.ways.back();
  if (way.empty() ||
      std::hypot(state_.base.x_m - way.back().x_m, state_.base.y_m - way.back().y_m) > kCalm_m)
    add_to_way();
}

void SiteMapper::look_back(const ElevationMapper& map) { hindsight_->finish(site_, map); }

void SiteMapper::note_traffic() { hindsight_->note_traffic(); }

const Traffic* SiteMapper::traffic() const { return hindsight_->traffic(); }

void SiteMapper::keep_all(const ElevationMapper& map)
{
  const CellRect window = rect_of(map.window());
  read(map, window);
  keep(window, 0);
}

/** Puts cells into the tiles of their floor. */
void SiteMapper::keep(const CellRect& cells, std::size_t first)
{
  const Votes here = votes(state_.floor, cells, first);
  if (here.contradict > here.agree && here.contradict >= kMinVotes)
    state_.floor = other_floor(cells, first, kMinVotes).value_or(floor_without(cells, first));
  else if (here.agree + here.contradict == 0 && state_.floors > 1)
    state_.floor = other_floor(cells, first, std::max(kMinVotes, references(cells, first) / 2))
                       .value_or(state_.floor);
  state_.floors = std::max(state_.floors, state_.floor + 1);
  store(cells, first);
}

void SiteMapper::store(const CellRect& cells, std::size_t first)
{
  const std::uint32_t seen_s = whole_seconds(state_.stamp_s);
  const CellRecord* const now = records_.first + first;
  const auto put = [&](const TilePart& part)
  {
    bool any = false;
    for_each_cell(cells, part, [&](std::size_t i, std::size_t) { any |= is_known(now[i]); });
    if (!any) return;
    hindsight_->touch(part.key);
    Tile& tile = site_.tiles.at(part.key);
    for_each_cell(
        cells, part,
        [&](std::size_t i, std::size_t at)
        {
          SiteCell& kept = tile.cells[at];
          if (!is_known(now[i])) return;
          if (is_measured(kept.cell) && contradict(kept.cell.ground_m, now[i].ground_m)) return;
          const float judged_whole = kept.cell.traversability;
          const bool keeps_judgement = is_known(kept.cell) && is_unchanged(kept.cell, now[i]) &&
                                       is_at_edge_of_window(cells, i);
          kept.cell = kept_of(now[i]);
          if (keeps_judgement) kept.cell.traversability = judged_whole;
          kept.seen_s = seen_s;
          if (!is_kept_.empty()) is_kept_[i] = true;
        });
    if (!site_.channels.empty()) store_channels(cells, first, part);
  };
  is_kept_.assign(site_.channels.empty() ? 0 : cells.size(), false);
  for_each_tile(cells, state_.floor, put);
}

/** Of the cells of a part that were just stored. What was known stays where the map knows nothing,
 * but for what stood there. */
void SiteMapper::store_channels(const CellRect& cells, std::size_t first, const TilePart& part)
{
  if (!channels_ && !site_.channel_tiles.has(part.key)) return;
  ChannelTile& tile = site_.channel_tiles.at(part.key);
  for_each_cell(
      cells, part,
      [&](std::size_t i, std::size_t at)
      {
        if (!is_kept_[i]) return;
        ChannelRecord& kept = tile.cells[at];
        if (!has_top(records_[first + i])) forget_standing(kept);
        for (std::size_t l = 0; channels_ && l < channel_places_.size(); ++l)
          if (const float v = channels_[first + i].values[l]; !std::isnan(v))
            kept.values[channel_places_[l]] = kept_value(v);
      });
}

/** Where a cell is judged by the part of its neighbourhood that is left. */
bool SiteMapper::is_at_edge_of_window(const CellRect& cells, std::size_t i) const
{
  const auto width = static_cast<std::size_t>(cells.width_cells);
  return is_at_edge(
      window_, cells.min_cell_x + static_cast<std::int64_t>(i % width),
      cells.min_cell_y + static_cast<std::int64_t>(i / width), margin_cells_);
}

/** After a frame on a floor that is not known yet. */
void SiteMapper::wait_for_floor(ElevationMapper& map)
{
  const bool drives =
      std::hypot(state_.base.x_m - state_.calm.x_m, state_.base.y_m - state_.calm.y_m) > kDrives_m;
  if (std::abs(state_.base.z_m - state_.calm.z_m) < kCalm_m)
    ++state_.frames_calm;
  else
  {
    state_.frames_calm = 0;
    state_.calm.z_m = state_.base.z_m;
  }
  if ((state_.frames_calm < kFramesCalm && !drives) || !choose_floor(map)) return;
  state_.choice = Choice::None;
  state_.calm = state_.base;
  if (restores_ && take_back_from(state_.floor, rects_.front(), 0)) write_back(map, records_.size);
}

/** The one that agrees most with what the window measured. False: it measured too little. */
bool SiteMapper::choose_floor(const ElevationMapper& map)
{
  const CellRect window = rect_of(map.window());
  read(map, window);
  if (references(window, 0) < kMinVotes) return false;
  const Votes here = votes(state_.floor, window, 0);
  const int agree = here.agree > here.contradict ? here.agree : 0;
  if (const auto other = other_floor(window, 0, agree + 1))
    state_.floor = *other;
  else if (agree == 0 && (state_.choice == Choice::LeftFloor || here.contradict > 0))
    state_.floor = new_floor();
  state_.floors = std::max(state_.floors, state_.floor + 1);
  return true;
}

void SiteMapper::read(const ElevationMapper& map, const CellRect& rect)
{
  rects_ = {rect};
  take_up(map, map.read_cells(rects_), map.window());
  channels_ = map.read_channels(rects_);
}

/** Cells are of the floor whose ground is where they were measured. */
void SiteMapper::take_up(
    const ElevationMapper& map, const CellRecords& records, const Window& window)
{
  window_ = window;
  margin_cells_ = neighbourhood_cells(map.parameters());
  records_ = records;
  references_.resize(records_.size);
  for (std::size_t i = 0; i < records_.size; ++i)
    references_[i] = {is_measured(records_[i]) ? records_[i].ground_m : NAN, kOtherFloor_m};
}

/** What was measured there on a floor, against the references. */
SiteMapper::Votes SiteMapper::votes(int floor, const CellRect& cells, std::size_t first)
{
  Votes sum;
  const auto count = [&](std::size_t i, const CellRecord& kept)
  {
    const Reference& r = references_[first + i];
    if (!is_measured(kept) || std::isnan(r.ground_m)) return;
    ++(std::abs(kept.ground_m - r.ground_m) > r.within_m ? sum.contradict : sum.agree);
  };
  for_each_kept_cell(site_.tiles, cells, floor, count);
  return sum;
}

/** The first of which nothing is kept: one that was chosen may have been left before that. */
int SiteMapper::new_floor() const
{
  int floor = 0;
  for (const TileKey& key : site_.tiles.keys()) floor = std::max(floor, key.floor + 1);
  return floor;
}

/** The first on which nothing contradicts. One that was begun a moment ago goes on with it. */
int SiteMapper::floor_without(const CellRect& cells, std::size_t first)
{
  int floor = 0;
  while (floor == state_.floor || votes(floor, cells, first).contradict > 0) ++floor;
  return floor;
}

/** The one with the most cells that agree: `min_agree` or more, and more than contradict. */
std::optional<int> SiteMapper::other_floor(const CellRect& cells, std::size_t first, int min_agree)
{
  std::optional<int> best;
  for (int floor = 0; floor < state_.floors; ++floor)
  {
    if (floor == state_.floor) continue;
    const Votes there = votes(floor, cells, first);
    if (there.agree < min_agree || there.agree <= there.contradict) continue;
    best = floor;
    min_agree = there.agree + 1;
  }
  return best;
}

int SiteMapper::references(const CellRect& cells, std::size_t first) const
{
  const auto from = references_.begin() + static_cast<std::ptrdiff_t>(first);
  return static_cast<int>(std::count_if(
      from, from + static_cast<std::ptrdiff_t>(cells.size()),
      [](const Reference& r) { return !std::isnan(r.ground_m); }));
}

void SiteMapper::follow(const Position& base)
{
  state_.base = base;
  if (state_.choice == Choice::None &&
      std::hypot(base.x_m - state_.calm.x_m, base.y_m - state_.calm.y_m) > kOtherFloor_m)
    state_.calm = base;
  const auto& way = site_.ways.back();
  if (way.empty() ||
      std::hypot(base.x_m - way.back().x_m, base.y_m - way.back().y_m, base.z_m - way.back().z_m) >=
          kWayPoint_m)
    add_to_way();
}

void SiteMapper::add_to_way()
{
  site_.ways.back().push_back(
      {static_cast<float>(state_.base.x_m), static_cast<float>(state_.base.y_m),
       static_cast<float>(state_.base.z_m), state_.floor, state_.stamp_s});
}

}  // namespace talus::site
