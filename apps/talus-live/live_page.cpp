#include "live_page.h"

#include "../common/run_app.h"

#include <sys/resource.h>
#include <talus/formats/page.h>
#include <talus/number_text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "cell_bands.h"

namespace talus::app
{
namespace
{
constexpr std::chrono::milliseconds kPeriod(200);  //!< of what is shown
constexpr std::chrono::seconds kTilePeriod(1);  //!< of each tile
constexpr int kShareOfTime = 20;  //!< the mapper waits for a page no more than a part of its time
constexpr std::size_t kMaxTilesAtOnce = 4, kMaxTiles = 30000, kPointsOfPart = 100;

constexpr std::array kLayers{
    Layer::Traversability, Layer::GroundElevation, Layer::Elevation, Layer::State, Layer::Reached};

/** Which of the values that a site keeps of a cell they are. */
constexpr auto kPlaces = []
{
  std::array<std::size_t, kLayers.size()> kept{};
  for (std::size_t k = 0; k < kept.size(); ++k)
    while (site::kKeptLayers[kept[k]] != kLayers[k]) ++kept[k];
  return kept;
}();

/** Without reaching, which is the last of them, where it tells nothing. */
std::size_t layer_count(bool is_reached) { return kLayers.size() - (is_reached ? 0 : 1); }

std::string random_name()
{
  std::random_device random;
  return std::to_string(random()) + std::to_string(random());
}
}  // namespace

LivePage::~LivePage()
{
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void LivePage::begin(const std::string& title, double resolution_m)
{
  resolution_m_ = resolution_m;
  const std::string run = random_name();
  server_.begin(formats::live_page({title, run, resolution_m, site::kTileCells}), run);
  thread_ = std::thread([this] { work(); });
}

bool LivePage::is_busy()
{
  const std::lock_guard lock(mutex_);
  return work_.has_value();
}

void LivePage::update(DriveMap& map)
{
  const auto begin = Clock::now();
  const bool is_new = map.frames() != frames_ || site_ != &map.site() || is_behind_;
  if (map.frames() == 0 || (!is_new && waiting_.empty()) || begin < next_ || is_busy()) return;
  frames_ = map.frames();
  Work work;
  work.is_new = is_new;
  look_for_new_map(map, work);
  take_window(map, work);
  take_squares(map, work);
  take_path(map.site(), work);
  work.robot =
      "\"x_m\":" + number_text(map.base().x()) + ",\"y_m\":" + number_text(map.base().y()) +
      ",\"z_m\":" + number_text(map.base().z()) + ",\"yaw_rad\":" + number_text(map.base().yaw()) +
      ",\"frames\":" + std::to_string(frames_) + ",\"driven_m\":" + fixed_text(driven_m_, 0);
  const auto end = Clock::now();
  next_ = std::max(begin + kPeriod, end + kShareOfTime * (end - begin));
  {
    const std::lock_guard lock(mutex_);
    work_ = std::move(work);
  }
  changed_.notify_all();
}

/** Another floor, or a map that was made again. */
void LivePage::look_for_new_map(DriveMap& map, Work& work)
{
  if (site_ == &map.site() && floor_ == map.floor()) return;
  work.begins_anew = site_ != nullptr;
  site_ = &map.site();
  floor_ = map.floor();
  is_reached_ = false;
  changes_ = 0;
  waiting_.clear();
  is_waiting_.clear();
  taken_.clear();
  points_.clear();
  driven_m_ = 0;
}

void LivePage::take_window(const DriveMap& map, Work& work)
{
  const Window w = map.window().window();
  const auto& reached = map.window().layer(Layer::Reached);
  if (!is_reached_ && std::count(reached.begin(), reached.end(), 1.0F) > 0)
  {
    is_reached_ = true;
    changes_ = 0;  // all tiles look otherwise now
  }
  auto& stack = work.window;
  stack.cells_x = stack.cells_y = w.cells;
  stack.resolution_m = w.resolution_m;
  stack.min_x_m = w.min_x_m();
  stack.min_y_m = w.min_y_m();
  for (std::size_t k = 0; k < layer_count(is_reached_); ++k)
  {
    stack.names.emplace_back(layer_name(kLayers[k]));
    stack.layers.push_back(map.window().layer(kLayers[k]));
  }
  work.min_x = w.min_cell_x;
  work.min_y = w.min_cell_y;
}

void LivePage::wait_for_square(const site::TileKey& key)
{
  if (is_waiting_.insert(key).second) waiting_.push_back(key);
}

/** Some of those that have changed, or lie beside one: the light of their edges has, too. */
void LivePage::take_squares(DriveMap& map, Work& work)
{
  auto& tiles = map.site().tiles;
  for (const auto& key : tiles.take_changed(changes_))
    for (int y = key.y - 1; key.floor == floor_ && y <= key.y + 1; ++y)
      for (int x = key.x - 1; x <= key.x + 1; ++x)
        if (tiles.has({key.floor, x, y})) wait_for_square({key.floor, x, y});
  const auto now = Clock::now();
  for (auto left = waiting_.size(); left > 0 && work.squares.size() < kMaxTilesAtOnce; --left)
  {
    const auto key = waiting_.front();
    waiting_.pop_front();
    const auto taken = taken_.find(key);
    if (taken != taken_.end() && now < taken->second + kTilePeriod)
    {
      waiting_.push_back(key);
      continue;
    }
    is_waiting_.erase(key);
    if (taken == taken_.end() && taken_.size() >= kMaxTiles) continue;
    taken_[key] = now;
    work.squares.push_back({key, square_of(map.site(), key)});
    put_window(work, work.squares.back());
    if (taken_.size() == kMaxTiles && taken == taken_.end())
      print_error("the map is too large for its page, which shows the first part of it");
  }
}

io::LayerStack LivePage::square_of(site::Site& site, const site::TileKey& key) const
{
  using site::kTileCells;
  const int margin = formats::live_margin_cells(resolution_m_), side = kTileCells + 2 * margin;
  io::LayerStack stack;
  stack.cells_x = stack.cells_y = side;
  stack.resolution_m = resolution_m_;
  for (std::size_t k = 0; k < layer_count(is_reached_); ++k)
  {
    stack.names.emplace_back(layer_name(kLayers[k]));
    stack.layers.emplace_back(
        static_cast<std::size_t>(side) * side, std::numeric_limits<float>::quiet_NaN());
  }
  // Of a tile beside it, along one side: its first cell that is taken, and where that goes.
  const auto first = [&](int beside) { return beside < 0 ? kTileCells - margin : 0; };
  const auto end = [&](int beside) { return beside > 0 ? margin : kTileCells; };
  for (int by = -1; by <= 1; ++by)
    for (int bx = -1; bx <= 1; ++bx)
    {
      const site::Tile* tile = site.tiles.find({key.floor, key.x + bx, key.y + by});
      if (!tile) continue;
      for (int y = first(by); y < end(by); ++y)
        for (int x = first(bx); x < end(bx); ++x)
        {
          const auto values = site::kept_values(tile->cells[y * kTileCells + x].cell);
          const auto to = static_cast<std::size_t>(margin + by * kTileCells + y) * side + margin +
                          bx * kTileCells + x;
          for (std::size_t k = 0; k < stack.layers.size(); ++k)
            stack.layers[k][to] = values[kPlaces[k]];
        }
    }
  return stack;
}

/** On a tile, so that nothing is missing until the next one comes. */
void LivePage::put_window(const Work& work, Square& square) const
{
  const auto& from = work.window;
  auto& to = square.cells;
  const auto margin = (to.cells_x - site::kTileCells) / 2;
  const auto dx = site::cell_of_tile(square.key.x, 0) - margin - work.min_x;
  const auto dy = site::cell_of_tile(square.key.y, 0) - margin - work.min_y;
  const auto& state = *from.find(layer_name(Layer::State));
  for (auto y = std::max<std::int64_t>(0, -dy);
       y < std::min<std::int64_t>(to.cells_y, from.cells_y - dy); ++y)
    for (auto x = std::max<std::int64_t>(0, -dx);
         x < std::min<std::int64_t>(to.cells_x, from.cells_x - dx); ++x)
    {
      const auto i = static_cast<std::size_t>((y + dy) * from.cells_x + x + dx);
      if (!(state[i] >= 1)) continue;
      for (std::size_t k = 0; k < to.layers.size(); ++k)
        to.layers[k][static_cast<std::size_t>(y * to.cells_x + x)] = from.layers[k][i];
    }
}

/** Of each way the parts to which points have come. */
void LivePage::take_path(const site::Site& site, Work& work)
{
  points_.resize(site.ways.size());
  for (std::size_t i = 0; i < site.ways.size(); ++i)
  {
    const auto& way = site.ways[i];
    if (way.size() == points_[i]) continue;
    for (std::size_t k = std::max<std::size_t>(points_[i], 1); k < way.size(); ++k)
      driven_m_ += std::hypot(way[k].x_m - way[k - 1].x_m, way[k].y_m - way[k - 1].y_m);
    // A part begins with the last point of the one before.
    for (auto part = (points_[i] > 0 ? points_[i] - 1 : 0) / kPointsOfPart;
         part * kPointsOfPart < way.size(); ++part)
    {
      std::string points;
      const auto end = std::min((part + 1) * kPointsOfPart + 1, way.size());
      for (auto k = part * kPointsOfPart; k < end; ++k)
        if (way[k].floor == floor_)
          points += (points.empty() ? "[" : ",[") + fixed_text(way[k].x_m, 2) + "," +
                    fixed_text(way[k].y_m, 2) + "]";
      const std::string place =
          "\"way\":" + std::to_string(i) + ",\"part\":" + std::to_string(part);
      work.path.push_back({place, "{" + place + ",\"points\":[" + points + "]}"});
    }
    points_[i] = way.size();
  }
}

void LivePage::work()
{
  ::setpriority(PRIO_PROCESS, 0, 10);  // of this thread: the map comes first
  for (;;)
  {
    Work work;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return ends_ || work_; });
      if (ends_) return;
      work = std::move(*work_);
    }
    show(work);
    const std::lock_guard lock(mutex_);
    work_.reset();
  }
}

void LivePage::show(const Work& work)
{
  if (work.begins_anew) server_.forget();
  const auto now = Clock::now();
  const bool is_due = server_.listeners() > 0 || now - shown_ >= std::chrono::seconds(1);
  is_behind_ = work.is_new && !is_due;
  if (work.is_new && is_due)
  {
    shown_ = now;
    constexpr int kEdge = 1;  // whose light is not known
    const auto cells = formats::live_cells(
        work.window, kEdge, static_cast<int>(work.min_x + kEdge),
        static_cast<int>(kEdge - work.min_y - work.window.cells_y));
    server_.show_now("{" + work.robot + ",\"cells\":" + (cells.empty() ? "null" : cells) + "}");
  }
  for (const auto& part : work.path) server_.keep(part.name, "path", part.data);
  const int margin = formats::live_margin_cells(resolution_m_);
  for (const auto& square : work.squares)
  {
    const auto cells = formats::live_cells(square.cells, margin, square.key.x, -1 - square.key.y);
    if (!cells.empty())
      server_.keep(
          std::to_string(square.key.x) + " " + std::to_string(square.key.y), "tile", cells);
  }
}

}  // namespace talus::app
