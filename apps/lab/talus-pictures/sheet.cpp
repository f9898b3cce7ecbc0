#include "sheet.h"

#include <opencv2/imgproc.hpp>
#include <picture_canvas.h>
#include <picture_legend.h>
#include <picture_style.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus::pictures
{
namespace
{
using io::Anchor;
using io::Canvas;
using io::Palette;
using io::TextStyle;

constexpr int kEdge_px = 12, kTitle_px = 40, kGap_px = 10, kWideGap_px = 28;
constexpr float kHeightSpan_m = 0.6F;  // of the colours: small steps shall show
const TextStyle kTitle{9, io::kInk, true, Anchor::Start, Anchor::Middle, false};
const TextStyle kWords{8, io::kFaintInk, false, Anchor::Start, Anchor::Middle, false};

io::LayerStyle style_of(const io::LayerStack& stack, const std::string& layer)
{
  for (auto& style : io::styles_of(stack))
    if (style.layer == layer) return style;
  throw std::invalid_argument("there is no layer " + layer);
}

/** Heights from the median of the ground on, so that all tiles of a world have one scale. */
io::ColourRange range_of(const io::LayerStack& stack, const io::LayerStyle& style)
{
  if (style.palette == Palette::Scores || style.palette == Palette::States) return {};
  if (style.palette == Palette::Amounts && !style.square_root)
    return {0, kChannelClasses - 1, false, false, 0, 0};  // classes of a channel
  if (style.palette == Palette::Amounts)
    return {0, 0.05F, false, false, 0, 0};  // a standard deviation [m]
  std::vector<float> ground = *stack.find(layer_name(Layer::GroundElevation));
  ground.erase(
      std::remove_if(ground.begin(), ground.end(), [](float z) { return std::isnan(z); }),
      ground.end());
  if (ground.empty()) return {};
  const auto middle = ground.begin() + static_cast<std::ptrdiff_t>(ground.size() / 2);
  std::nth_element(ground.begin(), middle, ground.end());
  return {*middle - kHeightSpan_m / 2, *middle + kHeightSpan_m / 2, false, false, 0, 0};
}

/** What the colours mean, in two rows; `of_scores`: in one. */
io::Legend legend(bool of_scores)
{
  constexpr double kSmall = 0.8;
  io::Legend legend(kSmall);
  legend.colours("blocked", io::colours_of(Palette::Scores), "free");
  legend.swatch(io::palette::kNotJudged);
  legend.swatch(io::palette::kNotSeen);
  if (of_scores) return legend;
  legend.colours("low", io::colours_of(Palette::Heights), "high, over 0.6 m");
  legend.new_row();
  for (const std::size_t i : {1, 2, 3, 4}) legend.swatch(io::palette::kStates[i]);
  legend.colours("standard deviation 0", io::colours_of(Palette::Amounts), "0.05 m");
  return legend;
}
}  // namespace

cv::Mat layer_image(
    const io::LayerStack& stack, const std::string& layer, double side_m, int tile_px)
{
  const auto style = style_of(stack, layer);
  const auto values = io::shown_values(stack, style);
  cv::Mat cells = io::paint_cells(
      values, stack.cells_x, stack.cells_y, style.palette, range_of(stack, style), io::kFewColours);
  if (layer == layer_name(Layer::Traversability))
    io::paint_not_judged(cells, values, *stack.find(layer_name(Layer::State)));
  const int side = static_cast<int>(std::lround(side_m / stack.resolution_m));
  cv::Mat square(side, side, CV_8UC3, io::bgr(io::palette::kNotSeen.rgb)), tile;
  const int shift = (side - cells.cols) / 2;  // the same to all sides: the robot is in the middle
  const cv::Rect all(0, 0, side, side), placed(shift, shift, cells.cols, cells.rows);
  const cv::Rect seen = all & placed;
  cells(seen - placed.tl()).copyTo(square(seen));
  cv::resize(square, tile, {tile_px, tile_px}, 0, 0, cv::INTER_NEAREST);
  return tile;
}

cv::Mat draw_sheet(
    const std::vector<Tile>& tiles, int columns, int together, const std::string& words,
    SheetLegend explained)
{
  const int tile_px = tiles.front().image.cols, count = static_cast<int>(tiles.size());
  const int rows = (count + columns - 1) / columns;
  const auto left_of = [&](int column)
  { return kEdge_px + column * (tile_px + kGap_px) + column / together * (kWideGap_px - kGap_px); };
  io::Legend all = legend(explained == SheetLegend::Scores);
  all.mark({0, 0}, words, [](Canvas&, cv::Point) {});
  const int width_px = left_of(columns - 1) + tile_px - kEdge_px;
  const int legend_px = all.height_px(width_px);
  Canvas canvas(
      width_px + 2 * kEdge_px,
      kEdge_px + rows * (kTitle_px + tile_px + kGap_px) + legend_px + kEdge_px);
  for (int i = 0; i < count; ++i)
  {
    const Tile& tile = tiles[static_cast<std::size_t>(i)];
    const int x = left_of(i % columns);
    const int y = kEdge_px + i / columns * (kTitle_px + tile_px + kGap_px);
    canvas.text(tile.title, x, y + 8, kTitle);
    canvas.text(tile.words, x, y + 26, kWords);
    canvas.paste(tile.image, x, y + kTitle_px);
    canvas.frame({x, y + kTitle_px, tile_px, tile_px}, io::kFaintInk);
    const double middle = tile_px / 2.0;
    io::draw_robot(canvas, {x + middle, y + kTitle_px + middle}, 0, 12);
  }
  all.draw(canvas, {kEdge_px, canvas.image().rows - kEdge_px - legend_px}, width_px);
  return canvas.image();
}

}  // namespace talus::pictures
