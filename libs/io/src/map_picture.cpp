#include <talus/io/map_picture.h>

#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include "picture_canvas.h"
#include "picture_legend.h"
#include "picture_panel.h"
#include "picture_relief.h"
#include "picture_style.h"

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <stdexcept>
#include <string_view>

namespace talus::io
{
namespace
{
/// @name Pixels
/// @{
constexpr int kEdge = 28;  //!< paper around everything
constexpr int kHeader = 88, kTitle = 28, kGap = 16;
constexpr int kLeft = 56, kBelow = 52;  //!< for the axes of the large map
constexpr double kLarge = 960, kSmall = 200;  //!< long sides of the maps
constexpr int kBetween = 44;  //!< the large map and the small ones
/// @}

/** Both heights share one scale, so that the same colour is the same height. */
ColourRange height_range(const LayerStack& stack)
{
  std::vector<float> heights;
  for (const char* name : {layer_name(Layer::Elevation), layer_name(Layer::GroundElevation)})
    if (const auto* layer = stack.find(name))
      heights.insert(heights.end(), layer->begin(), layer->end());
  return robust_range(std::move(heights), 0.1F);
}

ColourRange range_of(
    const LayerStyle& style, const std::vector<float>& values, const ColourRange& heights)
{
  switch (style.palette)
  {
    case Palette::Heights:
      return range_for(heights, values);
    case Palette::Amounts:
    {
      ColourRange range = robust_range(values, 1e-3F);
      if (style.square_root)
      {
        range.low = 0;
        range.values_below = false;
      }
      return range;
    }
    default:
      return {};
  }
}

bool is_empty(const LayerStack& stack, const LayerStyle& style)
{
  const auto& values = *stack.find(style.layer);
  return std::none_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

/** Takes out the layers without any value, and names them; keeps all when none has one. */
std::string take_out_empty(const LayerStack& stack, std::vector<LayerStyle>& styles)
{
  const auto first_empty = std::stable_partition(
      styles.begin(), styles.end(), [&](const LayerStyle& s) { return !is_empty(stack, s); });
  if (first_empty == styles.begin()) return "";
  std::string names;
  for (auto s = first_empty; s != styles.end(); ++s)
    names += (names.empty() ? "" : ", ") + s->layer;
  styles.erase(first_empty, styles.end());
  return names;
}

std::string subtitle_of(const LayerStack& s, double driven_m)
{
  const std::string driven = driven_m > 0 ? fixed_text(driven_m, 0) + " m driven, window of " : "";
  return driven + number_text(s.cells_x * s.resolution_m, 4) + " \u00d7 " +
         number_text(s.cells_y * s.resolution_m, 4) + " m, " + std::to_string(s.cells_x) +
         " \u00d7 " + std::to_string(s.cells_y) + " cells of " + number_text(s.resolution_m, 3) +
         " m, north up";
}

/** The text, cut in its middle where it is wider than the room for it. */
std::string fitted(const std::string& text, const TextStyle& style, double room_px)
{
  std::string shown = text;
  for (std::size_t keep = text.size(); keep > 8 && Canvas::text_width(shown, style) > room_px;)
  {
    --keep;
    shown = text.substr(0, keep / 2) + "..." + text.substr(text.size() - (keep - keep / 2));
  }
  return shown;
}

/** The traversability over the shaded ground, the way and the robot. */
void draw_terrain(
    Canvas& canvas, const Plot& plot, const LayerStack& stack, const PictureOptions& options)
{
  constexpr double kRobot_px = 44, kWay_px = 3;
  draw_cells(canvas, plot, paint_terrain(terrain_of(stack), stack.resolution_m));
  Canvas inside(plot.area.width, plot.area.height);
  inside.paste(canvas.image()(plot.area), 0, 0);
  std::vector<cv::Point2d> way;
  for (const auto& p : options.way)
    way.push_back(plot.pixel(p.x, p.y) - cv::Point2d(plot.area.tl()));
  if (way.size() > 1) draw_way_line(inside, way, kWay_px);
  canvas.paste(inside.image(), plot.area.x, plot.area.y);
  draw_robot_on(canvas, plot, options, kRobot_px);
}

Legend terrain_legend(const Plot& plot, const PictureOptions& options)
{
  Legend legend;
  add_terrain(legend);
  if (options.has_robot) legend.robot("robot");
  if (options.way.size() > 1) legend.way_line(palette::kPath.name);
  legend.scale_bar(plot.area.width / plot.width_m);
  return legend;
}

void draw_header(
    Canvas& canvas, const LayerStack& stack, const std::string& empty_layers,
    const PictureOptions& options)
{
  const TextStyle title{17, kInk, true, Anchor::Start, Anchor::Middle, false};
  const TextStyle plain{11, kFaintInk, false, Anchor::Start, Anchor::Middle, false};
  const int left = kEdge + kLeft - 1, room = canvas.image().cols - kEdge - left;
  const std::string text = options.title.empty() ? "Terrain map" : options.title;
  canvas.text(fitted(text, title, room), left, kEdge + 12, title);
  std::string subtitle = subtitle_of(stack, options.driven_m);
  if (!empty_layers.empty()) subtitle += "; no cell has a value: " + empty_layers;
  canvas.text(fitted(subtitle, plain, room), left, kEdge + 42, plain);
}

/** Where everything goes. */
struct Layout
{
  cv::Rect large;
  cv::Size small;
  int rows, columns, width;

  Layout(const LayerStack& stack, int small_count)
      : large({kEdge + kLeft, kEdge + kHeader}, plot_size(stack, kLarge)),
        small(plot_size(stack, kSmall))
  {
    rows = std::max(1, (large.height + kGap) / (small.height + kTitle + kGap));
    columns = (small_count + rows - 1) / rows;
    width = large.br().x + (columns > 0 ? kBetween + columns * step_x() : 0) + kEdge;
  }

  int step_x() const { return small.width + kScaleRoom_px; }
  cv::Rect small_area(int i) const
  {
    const int spare = rows > 1 ? (large.height - rows * (small.height + kTitle)) / (rows - 1) : 0;
    return {
        {large.br().x + kBetween + i / rows * step_x(),
         large.y + kTitle + i % rows * (small.height + kTitle + spare)},
        small};
  }
};
}  // namespace

std::string date_text(double stamp_s)
{
  constexpr double kYear1980_s = 315532800.0, kYear2200_s = 7258118400.0;
  if (!(stamp_s > kYear1980_s && stamp_s < kYear2200_s)) return "";
  const auto seconds = static_cast<std::time_t>(stamp_s);
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  std::array<char, 40> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &utc);
  return text.data();
}

cv::Mat draw_map(const LayerStack& stack, const PictureOptions& options)
{
  stack.require_sound();
  auto styles = styles_of(stack);
  const std::string empty_layers = take_out_empty(stack, styles);
  // The traversability is the large one; where there is none, the first layer.
  const auto is_score = [](const LayerStyle& s)
  { return s.layer == layer_name(Layer::Traversability); };
  const auto first = std::find_if(styles.begin(), styles.end(), is_score);
  const bool has_terrain = first != styles.end();
  if (has_terrain) std::rotate(styles.begin(), first, first + 1);

  const Layout layout(stack, static_cast<int>(styles.size()) - 1);
  const Plot large(layout.large, stack);
  const Legend legend = terrain_legend(large, options);
  const int room = std::max(layout.large.width, layout.width - 2 * kEdge - kLeft);
  const int foot = has_terrain ? legend.height_px(room) + kGap : 0;
  Canvas canvas(
      std::max(layout.width, layout.large.br().x + (has_terrain ? 0 : kScaleRoom_px) + kEdge),
      layout.large.br().y + kBelow + foot + kEdge);
  draw_header(canvas, stack, empty_layers, options);
  const ColourRange heights = height_range(stack);
  for (std::size_t i = 0; i < styles.size(); ++i)
  {
    const bool is_large = i == 0;
    const Plot plot(is_large ? layout.large : layout.small_area(static_cast<int>(i) - 1), stack);
    const auto values = shown_values(stack, styles[i]);
    if (is_large && has_terrain)
      draw_terrain(canvas, plot, stack, options);
    else
      draw_panel(
          canvas, plot, stack, styles[i], values, range_of(styles[i], values, heights), options);
  }
  draw_axes(canvas, large);
  if (has_terrain) legend.draw(canvas, {layout.large.x, layout.large.br().y + kBelow + kGap}, room);
  return canvas.image();
}

void write_png(const std::string& path, const cv::Mat& picture)
{
  std::vector<uchar> png;
  // The lowest level and one filter, which is what OpenCV takes where no level is given. A level of
  // 3 saves 3 to 11 % and takes twice as long; OpenCV's own strategy makes files half as large
  // again.
  if (!cv::imencode(
          ".png", picture, png, {cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_DEFAULT}))
    throw std::runtime_error(path + ": cannot make this picture");
  write_file(path, std::string_view(reinterpret_cast<const char*>(png.data()), png.size()));
}

void write_map_picture(
    const std::string& path, const LayerStack& stack, const PictureOptions& options)
{
  cv::Mat picture;
  try
  {
    picture = draw_map(stack, options);
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(path + ": cannot make this picture: " + e.what());
  }
  write_png(path, picture);
}

}  // namespace talus::io
