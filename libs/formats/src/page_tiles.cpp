#include "page_tiles.h"

#include "needed_layer.h"

#include <mrpt/system/string_utils.h>
#include <picture_relief.h>
#include <talus/channels.h>
#include <talus/number_text.h>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace talus::formats
{
namespace
{
constexpr int kMaxHeights = 65535;
constexpr float kMayDrop = 0.5F;  //!< sparsity below it

constexpr std::size_t kLayersOfPicture = 3;

/** The map, which has what terrain_of() needs. */
const io::LayerStack& judged(const io::LayerStack& map)
{
  needed_layer(map, Layer::Traversability);
  return map;
}

/** The layers that become the pixels of a tile, by its columns and rows. */
class Pixels
{
 public:
  Pixels(const PagePart& part, const PageCode& code)
      : part_(part),
        heights_(judged(part.cells)),
        state_(needed_layer(part.cells, Layer::State)),
        sparsity_(part.cells.find(layer_name(Layer::Sparsity))),
        age_(part.cells.find("age")),
        kind_(part.changes.find("kind")),
        change_(part.changes.find("change_m")),
        terrain_(io::terrain_of(part.cells, true)),
        shade_(io::hill_shade(terrain_.ground_m, part.cells.resolution_m)),
        code_(code)
  {
    for (const auto& channel : code.channels) channels_.push_back(part.cells.find(channel.name));
  }

  std::size_t channel_pictures() const
  {
    return (channels_.size() + kLayersOfPicture - 1) / kLayersOfPicture;
  }
  cv::Vec3b channels(int x, int row, std::size_t picture) const
  {
    const std::size_t i = index(x, row);
    cv::Vec3b codes(0, 0, 0);
    for (std::size_t k = 0; k < kLayersOfPicture; ++k)
    {
      const std::size_t layer = kLayersOfPicture * picture + k;
      if (layer >= channels_.size() || !is_known(x, row)) break;
      const float v = (*channels_[layer])[i];
      const PageCode::Channel& code = code_.channels[layer];
      if (std::isfinite(v))
        codes[static_cast<int>(kLayersOfPicture - 1 - k)] =
            byte(static_cast<int>(std::lround((v - code.lowest) / code.step)) + 1);
    }
    return codes;
  }

  bool is_known(int x, int row) const
  {
    const std::size_t i = index(x, row);
    return state_[i] >= 1 && !std::isnan(heights_.ground[i]);
  }
  /** What is known, how old it is, and how high it lies. */
  void measure(PageTile& tile) const
  {
    float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
    for (int row = 0; row < part_.cells_y; ++row)
      for (int x = 0; x < part_.cells_x; ++x)
      {
        if (!is_known(x, row)) continue;
        const std::size_t i = index(x, row);
        ++tile.known_cells;
        if (age_) tile.oldest_s = std::fmax(tile.oldest_s, (*age_)[i]);
        lowest = std::min(lowest, heights_.ground[i]);
        highest = std::max(highest, heights_.ground[i]);
      }
    if (tile.known_cells == 0) return;
    tile.lowest_m = lowest;
    tile.step_m = std::max(tile.step_m, (double{highest} - lowest) / (kMaxHeights - 1.0));
  }

  /** Pictures of OpenCV are blue, green, red. */
  cv::Vec3b ground(int x, int row, const PageTile& tile) const
  {
    if (!is_known(x, row)) return {255, 0, 0};
    const auto h = static_cast<int>(std::clamp<long>(
        std::lround((heights_.ground[index(x, row)] - tile.lowest_m) / tile.step_m) + 1, 1,
        kMaxHeights));
    const float t = terrain_.score(row + part_.north, x + part_.west);
    const int score =
        std::isnan(t) ? 255 : static_cast<int>(std::lround(254 * std::clamp(t, 0.0F, 1.0F)));
    return cv::Vec3b(byte(score), byte(h & 255), byte(h >> 8));
  }
  cv::Vec3b more(int x, int row) const
  {
    if (!is_known(x, row)) return {0, 255, 0};
    const std::size_t i = index(x, row);
    const int light = static_cast<int>(std::lround(15 * shade_(row + part_.north, x + part_.west)));
    const bool drops = sparsity_ && (*sparsity_)[i] < kMayDrop;
    return cv::Vec3b(
        byte(state(x, row) | (drops ? 8 : 0) | light << 4), byte(age(i)), byte(tall(i)));
  }
  /** A CellState, or one more for what was measured and is not reached. */
  int state(int x, int row) const
  {
    const auto told = static_cast<CellState>(state_[index(x, row)]);
    const bool apart =
        told == CellState::Measured && terrain_.measured(row + part_.north, x + part_.west) == 1;
    return apart ? kCellStates : static_cast<int>(told);
  }
  cv::Vec3b change(int x, int row) const
  {
    const std::size_t i = index(x, row);
    if (!kind_ || !change_ || !((*kind_)[i] > 0)) return {0, 0, 0};
    const double size = std::abs((*change_)[i]) / PageCode::kChangeStep_m;
    return cv::Vec3b(
        0, byte(static_cast<int>(std::min(255.0, size))), byte(static_cast<int>((*kind_)[i])));
  }

 private:
  std::size_t index(int x, int row) const
  {
    return static_cast<std::size_t>(part_.cells.cells_y - 1 - row - part_.north) *
               part_.cells.cells_x +
           static_cast<std::size_t>(x + part_.west);
  }
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

  const PagePart& part_;
  Heights heights_;
  const std::vector<float>& state_;
  const std::vector<float>*sparsity_, *age_, *kind_, *change_;
  std::vector<const std::vector<float>*> channels_;
  io::Terrain terrain_;
  cv::Mat1f shade_;
  const PageCode& code_;
};

std::vector<unsigned char> png(const cv::Mat3b& picture)
{
  constexpr int kCompression = 6;  // 9 takes three times as long for 3 % less
  std::vector<unsigned char> bytes;
  cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, kCompression});
  return bytes;
}

std::string base64(const std::vector<unsigned char>& bytes)
{
  std::string text;
  if (!bytes.empty()) mrpt::system::encodeBase64(bytes, text);
  text.erase(  // it is broken into lines
      std::remove_if(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }),
      text.end());
  return '"' + text + '"';
}
}  // namespace

void PageCode::Channel::add(const std::vector<float>& layer)
{
  for (const float v : layer)
  {
    if (!std::isfinite(v)) continue;
    lowest = is_empty_ ? v : std::fmin(lowest, v);
    highest = is_empty_ ? v : std::fmax(highest, v);
    is_whole_ = is_whole_ && v == std::floor(v);
    is_empty_ = false;
  }
}

void PageCode::Channel::finish()
{
  constexpr double kMaxCode = 255;
  if (is_empty_) return;
  const bool is_exact = is_whole_ && highest - lowest < kMaxCode;
  is_class = is_exact && lowest >= 0 && highest < kChannelClasses;
  step = is_exact ? 1 : std::max((highest - lowest) / (kMaxCode - 1), 1e-9);
}

std::size_t PageTile::bytes() const
{
  std::size_t bytes = ground.size() + more.size() + changes.size();
  for (const auto& picture : channels) bytes += picture.size();
  return bytes;
}

std::optional<PageTile> page_tile(const PagePart& part, const PageCode& code)
{
  const auto& state = needed_layer(part.cells, Layer::State);
  const auto is_known = [](float s) { return s >= 1; };
  if (std::none_of(state.begin(), state.end(), is_known) && part.changes.names.empty())
    return std::nullopt;
  const Pixels pixels(part, code);
  PageTile tile;
  pixels.measure(tile);
  const cv::Size size(part.cells_x, part.cells_y);
  cv::Mat3b ground(size), more(size), changes(size);
  std::vector<cv::Mat3b> channels;
  for (std::size_t k = 0; k < pixels.channel_pictures(); ++k) channels.emplace_back(size);
  bool is_changed = false;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
    {
      ground(y, x) = pixels.ground(x, y, tile);
      more(y, x) = pixels.more(x, y);
      changes(y, x) = pixels.change(x, y);
      is_changed = is_changed || changes(y, x)[2] != 0;
      for (std::size_t k = 0; k < channels.size(); ++k)
        channels[k](y, x) = pixels.channels(x, y, k);
    }
  if (tile.known_cells == 0 && !is_changed) return std::nullopt;
  tile.ground = png(ground);
  tile.more = png(more);
  if (is_changed) tile.changes = png(changes);
  for (const cv::Mat3b& picture : channels) tile.channels.push_back(png(picture));
  return tile;
}

std::string text_of(const PageTile& tile)
{
  std::string text = "[" + std::to_string(tile.column) + "," + std::to_string(tile.row) + "," +
                     number_text(tile.lowest_m) + "," + number_text(tile.step_m) + "," +
                     base64(tile.ground) + "," + base64(tile.more) + "," + base64(tile.changes) +
                     ",[";
  for (std::size_t k = 0; k < tile.channels.size(); ++k)
    text += (k > 0 ? "," : "") + base64(tile.channels[k]);
  return text + "]]";
}

}  // namespace talus::formats
