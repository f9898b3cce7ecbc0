#include "pictures.h"

#include <talus/io/map_picture.h>
#include <talus/io/score_colour.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace talus::baselines
{
namespace
{
constexpr int kGap_px = 8, kHeading_px = 30, kName_px = 160, kLegend_px = 40;
constexpr int kFewRows = 4, kLargeTile_px = 320, kSmallTile_px = 160;
const cv::Scalar kPaper(255, 255, 255), kInk(40, 40, 40);
const cv::Vec3b kUnknownColor(205, 205, 205);

/** BGR. */
cv::Vec3b traversability_color(float v)
{
  if (v != v) return kUnknownColor;
  const auto c = io::score_colour(v);
  return {c[2], c[1], c[0]};
}

/** Purple is low, red is high. */
cv::Vec3b height_color(float v, float low, float high)
{
  if (v != v) return kUnknownColor;
  const float t = std::clamp((v - low) / std::max(high - low, 1e-3f), 0.0f, 1.0f);
  cv::Mat3b hsv(1, 1, cv::Vec3b(static_cast<std::uint8_t>(std::lround(140 * (1 - t))), 200, 235));
  cv::Mat3b bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  return bgr(0, 0);
}

/** Where the sensor is and where it looks. */
void draw_robot(cv::Mat& tile, const Window& w, const Pose& T)
{
  const double scale = static_cast<double>(tile.cols) / (w.cells * w.resolution_m);
  const auto pixel = [&](double x_m, double y_m)
  {
    return cv::Point(
        static_cast<int>(std::lround((x_m - w.min_x_m()) * scale)),
        tile.rows - 1 - static_cast<int>(std::lround((y_m - w.min_y_m()) * scale)));
  };
  const double length_m = 0.6;
  const cv::Point tip = pixel(T.x() + length_m * T.m[0], T.y() + length_m * T.m[4]);
  cv::arrowedLine(tile, pixel(T.x(), T.y()), tip, {255, 255, 255}, 4, cv::LINE_AA, 0, 0.4);
  cv::arrowedLine(tile, pixel(T.x(), T.y()), tip, {0, 0, 0}, 2, cv::LINE_AA, 0, 0.4);
}

template <typename Color>
cv::Mat draw_layer(const std::vector<float>& layer, const Snapshot& s, int tile_px, Color color)
{
  const int n = s.window.cells;
  cv::Mat small(n, n, CV_8UC3, kUnknownColor), tile;
  if (!layer.empty())
    for (int k = 0; k < n * n; ++k)
      small.at<cv::Vec3b>(n - 1 - k / n, k % n) = color(layer[static_cast<std::size_t>(k)]);
  cv::resize(
      small, tile, {tile_px, tile_px}, 0, 0, n < tile_px ? cv::INTER_NEAREST : cv::INTER_AREA);
  draw_robot(tile, s.window, s.T_map_sensor);
  cv::rectangle(tile, {0, 0}, {tile_px - 1, tile_px - 1}, {120, 120, 120}, 1);
  return tile;
}

bool any_truth(const std::vector<Evaluation>& evaluations)
{
  return std::any_of(
      evaluations.begin(), evaluations.end(), [](const Evaluation& e) { return e.has_truth; });
}

int tile_size_px(std::size_t rows) { return rows <= kFewRows ? kLargeTile_px : kSmallTile_px; }

void write_text(cv::Mat& canvas, const std::string& text, cv::Point at, double size = 0.5)
{
  cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
}

/** One row of tiles with the name of its world. */
struct Row
{
  std::string name;
  std::vector<cv::Mat> tiles;
};

cv::Mat assemble(
    const std::vector<std::string>& headings, const std::vector<Row>& rows, int tile_px)
{
  const int columns = static_cast<int>(headings.size()), count = static_cast<int>(rows.size());
  cv::Mat canvas(
      kHeading_px + count * (tile_px + kGap_px) + kLegend_px,
      kName_px + columns * (tile_px + kGap_px), CV_8UC3, kPaper);
  for (int c = 0; c < columns; ++c)
    write_text(
        canvas, headings[static_cast<std::size_t>(c)],
        {kName_px + c * (tile_px + kGap_px), kHeading_px - 9}, 0.55);
  for (int r = 0; r < count; ++r)
  {
    const Row& row = rows[static_cast<std::size_t>(r)];
    const int y = kHeading_px + r * (tile_px + kGap_px);
    write_text(canvas, row.name, {6, y + tile_px / 2}, 0.45);
    for (std::size_t c = 0; c < row.tiles.size(); ++c)
      row.tiles[c].copyTo(canvas(
          cv::Rect(kName_px + static_cast<int>(c) * (tile_px + kGap_px), y, tile_px, tile_px)));
  }
  return canvas;
}

/** A strip of colours with words at its ends, at the foot of the picture. */
template <typename Color>
int draw_strip(
    cv::Mat& canvas, int x, const std::string& left, const std::string& right, Color color)
{
  const int y = canvas.rows - kLegend_px + 12, width = 160, height = 16;
  const auto text_px = [](const std::string& s)
  { return cv::getTextSize(s, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr).width; };
  write_text(canvas, left, {x, y + 13});
  x += text_px(left) + 8;
  for (int i = 0; i < width; ++i)
    cv::line(
        canvas, {x + i, y}, {x + i, y + height},
        cv::Scalar(color(static_cast<float>(i) / (width - 1))), 1);
  write_text(canvas, right, {x + width + 8, y + 13});
  return x + width + 8 + text_px(right) + 40;
}

void draw_patch(cv::Mat& canvas, int x, const std::string& text, const cv::Vec3b& color)
{
  const int y = canvas.rows - kLegend_px + 12;
  cv::rectangle(canvas, {x, y}, {x + 24, y + 16}, cv::Scalar(color), cv::FILLED);
  write_text(canvas, text, {x + 32, y + 13});
}

/** Range of colours of one world: that of the true ground, or of what was measured. */
std::pair<float, float> height_range(const Snapshot& s)
{
  std::vector<float> heights;
  for (float h : s.true_ground_m.empty() ? s.sparse.ground_m : s.true_ground_m)
    if (h == h) heights.push_back(h);
  if (heights.empty()) return {0, 1};
  std::sort(heights.begin(), heights.end());
  const float low = heights[heights.size() / 50],
              high = heights[heights.size() - 1 - heights.size() / 50];
  const float margin = std::max(0.1f * (high - low), 0.1f);
  return {low - margin, high + margin};
}

}  // namespace

void write_maps_picture(const std::string& path, const std::vector<Evaluation>& evaluations)
{
  const int tile_px = tile_size_px(evaluations.size());
  const bool truth = any_truth(evaluations);
  std::vector<std::string> headings;
  if (truth) headings.emplace_back("truth");
  std::vector<Row> rows;
  for (const Evaluation& e : evaluations)
  {
    const Snapshot& s = e.snapshot;
    Row row{e.name, {}};
    if (truth) row.tiles.push_back(draw_layer(s.true_label, s, tile_px, traversability_color));
    for (const auto& [name, map] : s.maps)
    {
      if (rows.empty()) headings.push_back(name);
      row.tiles.push_back(draw_layer(map.traversability, s, tile_px, traversability_color));
    }
    rows.push_back(std::move(row));
  }
  cv::Mat canvas = assemble(headings, rows, tile_px);
  const int x = draw_strip(
      canvas, kName_px, "risky", "free",
      [](float t) { return traversability_color(0.01f + 0.99f * t); });
  draw_patch(canvas, x, "impassable", traversability_color(0));
  draw_patch(canvas, x + 150, "unknown", kUnknownColor);
  io::write_png(path, canvas);
}

void write_fills_picture(const std::string& path, const std::vector<Evaluation>& evaluations)
{
  const int tile_px = tile_size_px(evaluations.size());
  const bool truth = any_truth(evaluations);
  std::vector<std::string> headings{"measured ground"};
  if (truth) headings.emplace_back("truth");
  std::vector<Row> rows;
  for (const Evaluation& e : evaluations)
  {
    const Snapshot& s = e.snapshot;
    if (s.fills.empty()) continue;
    const auto [low, high] = height_range(s);
    const auto color = [low = low, high = high](float v) { return height_color(v, low, high); };
    Row row{e.name, {draw_layer(s.sparse.ground_m, s, tile_px, color)}};
    if (truth) row.tiles.push_back(draw_layer(s.true_ground_m, s, tile_px, color));
    for (const auto& [name, fill] : s.fills)
    {
      if (rows.empty()) headings.push_back(name);
      row.tiles.push_back(draw_layer(fill, s, tile_px, color));
    }
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return;
  cv::Mat canvas = assemble(headings, rows, tile_px);
  const int x = draw_strip(
      canvas, kName_px, "lowest ground of the world", "highest",
      [](float t) { return height_color(t, 0, 1); });
  draw_patch(canvas, x, "unknown", kUnknownColor);
  io::write_png(path, canvas);
}

}  // namespace talus::baselines
