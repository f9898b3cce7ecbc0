#include <talus/io/map_picture.h>

#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include "picture_canvas.h"
#include "picture_panel.h"
#include "picture_style.h"

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

namespace talus::io
{
namespace
{
constexpr int kColumns = 3;
constexpr int kEdge = 24;  // paper around everything
constexpr int kHeader = 84;

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

std::string subtitle_of(const LayerStack& s)
{
  return number_text(s.cells_x * s.resolution_m, 4) + " x " +
         number_text(s.cells_y * s.resolution_m, 4) + " m, " + std::to_string(s.cells_x) + " x " +
         std::to_string(s.cells_y) + " cells of " + number_text(s.resolution_m, 3) + " m, north up";
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

/** The Latin letters that the picture can draw; '?' for any other. */
std::string drawable(std::string text)
{
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text;
}

/** Title, what the window is, what has no panel, and what arrow and grey mean. */
void draw_header(
    Canvas& canvas, const LayerStack& stack, const std::string& empty_layers,
    const PictureOptions& options, int left, int right)
{
  const TextStyle title{18, kInk, true, Anchor::Start, Anchor::Middle, false};
  const TextStyle plain{12, kFaintInk, false, Anchor::Start, Anchor::Middle, false};
  const std::string text = options.title.empty() ? "Terrain map" : drawable(options.title);
  double x = right;
  const int y = kEdge + 14;
  const auto legend = [&](const std::string& word)
  {
    x -= Canvas::text_width(word, plain);
    canvas.text(word, x, y, plain);
    x -= 26;
  };
  legend("no data");
  const cv::Rect swatch(static_cast<int>(x), y - 9, 18, 18);
  canvas.fill(swatch, kUnknownColour);
  canvas.frame(swatch, kInk);
  x -= 28;
  if (options.has_robot)
  {
    legend("robot");
    draw_robot(canvas, {x + 8, static_cast<double>(y)}, 0, 20);
    x -= 28;
  }
  canvas.text(fitted(text, title, x - left), left, y, title);
  std::string subtitle = subtitle_of(stack);
  if (!empty_layers.empty()) subtitle += "; no cell has a value: " + drawable(empty_layers);
  canvas.text(fitted(subtitle, plain, right - left), left, y + 34, plain);
}
}  // namespace

cv::Mat draw_map(const LayerStack& stack, const PictureOptions& options)
{
  stack.require_sound();
  auto styles = styles_of(stack);
  const std::string empty_layers = take_out_empty(stack, styles);
  const PanelMargins m;
  const cv::Size plot = plot_size(stack);
  const cv::Size panel(plot.width + m.left + m.right, plot.height + m.top + m.bottom);
  const int count = static_cast<int>(styles.size());
  const int columns = std::min(kColumns, count), rows = (count + columns - 1) / columns;
  Canvas canvas(columns * panel.width + 2 * kEdge, rows * panel.height + kHeader + 2 * kEdge);

  draw_header(
      canvas, stack, empty_layers, options, kEdge + m.left - 1, canvas.image().cols - kEdge - 40);
  const ColourRange heights = height_range(stack);
  for (int i = 0; i < count; ++i)
  {
    const cv::Point corner(
        kEdge + (i % columns) * panel.width, kEdge + kHeader + (i / columns) * panel.height);
    const auto values = shown_values(stack, styles[i]);
    draw_panel(
        canvas, corner, stack, styles[i], values, range_of(styles[i], values, heights), options);
  }
  return canvas.image();
}

void write_png(const std::string& path, const cv::Mat& picture)
{
  std::vector<uchar> png;
  // OpenCV's own choice is fast, and makes files of twice the size.
  if (!cv::imencode(".png", picture, png, {cv::IMWRITE_PNG_COMPRESSION, 6}))
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
