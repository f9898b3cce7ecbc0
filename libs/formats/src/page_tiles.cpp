#include "page_tiles.h"

#include "needed_layer.h"

#include <picture_relief.h>
#include <talus/channels.h>
#include <talus/formats/page.h>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace talus::formats
{
namespace
{
constexpr int kMaxHeights = 65535;
constexpr float kMayDrop = 0.5F;  //!< sparsity below it

constexpr std::size_t kLayersOfPicture = 3;
constexpr double kMaxCode = 255;

PageCode::Channel code_of_channel(const std::string& name, const std::vector<float>& layer)
{
  PageCode::Channel code;
  code.name = name;
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
  bool is_whole = true;
  for (const float v : layer)
  {
    if (!std::isfinite(v)) continue;
    lowest = std::min(lowest, v);
    highest = std::max(highest, v);
    is_whole = is_whole && v == std::floor(v);
  }
  if (lowest > highest) return code;
  code.lowest = lowest;
  code.highest = highest;
  const bool is_exact = is_whole && code.highest - code.lowest < kMaxCode;
  code.is_class = is_exact && code.lowest >= 0 && code.highest < kChannelClasses;
  code.step = is_exact ? 1 : std::max((code.highest - code.lowest) / (kMaxCode - 1), 1e-9);
  return code;
}

/** The map, which has what terrain_of() needs. */
const io::LayerStack& judged(const io::LayerStack& map)
{
  needed_layer(map, Layer::Traversability);
  return map;
}

/** The layers that become the pixels of a page. */
class Pixels
{
 public:
  Pixels(const io::LayerStack& map, const io::LayerStack* changes, PageCode& code)
      : map_(map),
        heights_(judged(map)),
        state_(needed_layer(map, Layer::State)),
        sparsity_(map.find(layer_name(Layer::Sparsity))),
        age_(map.find("age")),
        kind_(changes ? changes->find("kind") : nullptr),
        change_(changes ? changes->find("change_m") : nullptr),
        terrain_(io::terrain_of(map)),
        shade_(io::hill_shade(terrain_.ground_m, map.resolution_m))
  {
    find_range(code);
    code.channels.clear();
    for (const std::string& name : channel_bands(map.names))
    {
      channels_.push_back(map.find(name));
      code.channels.push_back(code_of_channel(name, *channels_.back()));
    }
    code_ = code;
  }

  std::size_t channel_pictures() const
  {
    return (channels_.size() + kLayersOfPicture - 1) / kLayersOfPicture;
  }
  cv::Vec3b channels(std::size_t i, std::size_t picture) const
  {
    cv::Vec3b codes(0, 0, 0);
    for (std::size_t k = 0; k < kLayersOfPicture; ++k)
    {
      const std::size_t layer = kLayersOfPicture * picture + k;
      if (layer >= channels_.size() || !is_known(i)) break;
      const float v = (*channels_[layer])[i];
      const PageCode::Channel& code = code_.channels[layer];
      if (std::isfinite(v))
        codes[static_cast<int>(kLayersOfPicture - 1 - k)] =
            byte(static_cast<int>(std::lround((v - code.lowest) / code.step)) + 1);
    }
    return codes;
  }

  std::size_t index(int x, int row) const
  {
    return static_cast<std::size_t>(map_.cells_y - 1 - row) * map_.cells_x + x;
  }
  bool is_known(std::size_t i) const { return state_[i] >= 1 && !std::isnan(heights_.ground[i]); }

  /** Pictures of OpenCV are blue, green, red. */
  cv::Vec3b ground(std::size_t i, int x, int row) const
  {
    if (!is_known(i)) return {255, 0, 0};
    const auto h = static_cast<int>(std::clamp<long>(
        std::lround((heights_.ground[i] - code_.lowest_m) / code_.step_m) + 1, 1, kMaxHeights));
    const float t = terrain_.score(row, x);
    const int score =
        std::isnan(t) ? 255 : static_cast<int>(std::lround(254 * std::clamp(t, 0.0F, 1.0F)));
    return cv::Vec3b(byte(score), byte(h & 255), byte(h >> 8));
  }
  cv::Vec3b more(std::size_t i, int x, int row) const
  {
    if (!is_known(i)) return {0, 255, 0};
    const int light = static_cast<int>(std::lround(15 * shade_(row, x)));
    const bool drops = sparsity_ && (*sparsity_)[i] < kMayDrop;
    return cv::Vec3b(
        byte(state(i, x, row) | (drops ? 8 : 0) | light << 4), byte(age(i)), byte(tall(i)));
  }
  /** A CellState, or one more for what was measured and is not reached. */
  int state(std::size_t i, int x, int row) const
  {
    const auto told = static_cast<CellState>(state_[i]);
    const bool apart = told == CellState::Measured && terrain_.measured(row, x) == 1;
    return apart ? kCellStates : static_cast<int>(told);
  }
  cv::Vec3b change(std::size_t i) const
  {
    if (!kind_ || !change_ || !((*kind_)[i] > 0)) return {0, 0, 0};
    const double size = std::abs((*change_)[i]) / PageCode::kChangeStep_m;
    return cv::Vec3b(
        0, byte(static_cast<int>(std::min(255.0, size))), byte(static_cast<int>((*kind_)[i])));
  }

 private:
  static uchar byte(int v) { return static_cast<uchar>(v); }
  int tall(std::size_t i) const
  {
    if (!heights_.stands(i)) return 0;
    const double steps = std::ceil((heights_.top[i] - heights_.ground[i]) / PageCode::kTallStep_m);
    return static_cast<int>(std::min(255.0, steps));
  }
  int age(std::size_t i) const
  {
    if (!age_ || std::isnan((*age_)[i])) return 255;
    return static_cast<int>(std::min(
        254.0, std::round(PageCode::kAgeSteps * std::log2(1.0 + std::max(0.0F, (*age_)[i])))));
  }
  void find_range(PageCode& code) const
  {
    code.known_cells = 0;
    float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
    for (std::size_t i = 0; i < heights_.ground.size(); ++i)
      if (is_known(i))
      {
        ++code.known_cells;
        if (age_) code.oldest_s = std::fmax(code.oldest_s, (*age_)[i]);
        lowest = std::min(lowest, heights_.ground[i]);
        highest = std::max(highest, heights_.ground[i]);
      }
    if (lowest > highest) throw std::runtime_error("no cell of the map is known");
    code.lowest_m = lowest;
    code.step_m = std::max(code.step_m, (highest - lowest) / (kMaxHeights - 1.0));
  }

  const io::LayerStack& map_;
  Heights heights_;
  const std::vector<float>& state_;
  const std::vector<float>*sparsity_, *age_, *kind_, *change_;
  std::vector<const std::vector<float>*> channels_;
  io::Terrain terrain_;
  cv::Mat1f shade_;
  PageCode code_;
};

std::vector<unsigned char> png(const cv::Mat3b& picture)
{
  constexpr int kCompression = 6;  // 9 takes three times as long for 3 % less
  std::vector<unsigned char> bytes;
  cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, kCompression});
  return bytes;
}

/** Nothing where no cell of it is known. */
std::vector<PageTile> tile_of(const io::LayerStack& map, const Pixels& pixels, int column, int row)
{
  const int x0 = column * kPageTile_cells, y0 = row * kPageTile_cells;
  const cv::Size size(
      std::min(kPageTile_cells, map.cells_x - x0), std::min(kPageTile_cells, map.cells_y - y0));
  cv::Mat3b ground(size), more(size), changes(size);
  std::vector<cv::Mat3b> channels;
  for (std::size_t k = 0; k < pixels.channel_pictures(); ++k) channels.emplace_back(size);
  bool is_known = false, is_changed = false;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
    {
      const std::size_t i = pixels.index(x0 + x, y0 + y);
      is_known = is_known || pixels.is_known(i);
      ground(y, x) = pixels.ground(i, x0 + x, y0 + y);
      more(y, x) = pixels.more(i, x0 + x, y0 + y);
      changes(y, x) = pixels.change(i);
      is_changed = is_changed || changes(y, x)[2] != 0;
      for (std::size_t k = 0; k < channels.size(); ++k) channels[k](y, x) = pixels.channels(i, k);
    }
  if (!is_known && !is_changed) return {};
  PageTile tile{column, row, png(ground), png(more), {}, {}};
  if (is_changed) tile.changes = png(changes);
  for (const cv::Mat3b& picture : channels) tile.channels.push_back(png(picture));
  return {tile};
}
}  // namespace

std::optional<std::vector<PageTile>> page_tiles(
    const io::LayerStack& map, const io::LayerStack* changes, std::size_t max_bytes, PageCode& code)
{
  const Pixels pixels(map, changes, code);
  std::vector<PageTile> tiles;
  std::size_t bytes = 0;
  for (int row = 0; row * kPageTile_cells < map.cells_y; ++row)
    for (int column = 0; column * kPageTile_cells < map.cells_x; ++column)
      for (PageTile& tile : tile_of(map, pixels, column, row))
      {
        bytes += tile.ground.size() + tile.more.size() + tile.changes.size();
        for (const auto& picture : tile.channels) bytes += picture.size();
        if (bytes > max_bytes) return std::nullopt;
        tiles.push_back(std::move(tile));
      }
  return tiles;
}

}  // namespace talus::formats
