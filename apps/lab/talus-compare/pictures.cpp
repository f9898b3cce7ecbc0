#include "report.h"

#include <talus/io/map_picture.h>

#include <picture_canvas.h>
#include <picture_legend.h>
#include <picture_style.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace talus::baselines
{
namespace
{
using io::Anchor;
using io::Canvas;
using io::Palette;
using io::TextStyle;

constexpr int kEdge_px = 16, kGap_px = 8, kHeading_px = 26, kLegend_px = 46;
constexpr int kFewRows = 4, kLargeTile_px = 320, kSmallTile_px = 160;
const TextStyle kHeading{12, io::kInk, true, Anchor::Start, Anchor::Middle, false};
const TextStyle kPlain{11, io::kInk, false, Anchor::Start, Anchor::Middle, false};

/** One row of tiles with the name of its world. */
struct Row
{
  std::string name;
  std::vector<cv::Mat> tiles;
};

/** Where the sensor is and where it looks, drawn on cells that were made as large as the tile. */
cv::Mat with_robot(const cv::Mat& tile, const Snapshot& s)
{
  const double scale = static_cast<double>(tile.cols) / (s.window.cells * s.window.resolution_m);
  const Pose& T = s.T_map_sensor;
  Canvas canvas(tile.cols, tile.rows);
  canvas.paste(tile, 0, 0);
  const cv::Point2d at(
      (T.x() - s.window.min_x_m()) * scale, tile.rows - (T.y() - s.window.min_y_m()) * scale);
  io::draw_robot(canvas, at, std::atan2(T.m[4], T.m[0]), 18);
  return canvas.image();
}

cv::Mat tile_of(const cv::Mat& cells, const Snapshot& s, int tile_px)
{
  cv::Mat tile;
  const int how = cells.cols < tile_px ? cv::INTER_NEAREST : cv::INTER_AREA;
  cv::resize(cells, tile, {tile_px, tile_px}, 0, 0, how);
  return with_robot(tile, s);
}

cv::Mat paint_scores(const std::vector<float>& layer, const Snapshot& s)
{
  const int n = s.window.cells;
  if (layer.empty()) return {n, n, CV_8UC3, io::bgr(io::palette::kNotSeen.rgb)};  // no truth
  return io::paint_cells(layer, n, n, Palette::Scores, {}, io::kFewColours);
}

cv::Mat traversability_tile(const Surfaces& map, const Snapshot& s, int tile_px)
{
  cv::Mat cells = paint_scores(map.traversability, s);
  std::vector<float> known(map.size());
  for (std::size_t k = 0; k < known.size(); ++k) known[k] = map.known(k) ? 1.0F : 0.0F;
  io::paint_not_judged(cells, map.traversability, known);
  return tile_of(cells, s, tile_px);
}

/** Rows of tiles below their headings, and room for a legend. */
Canvas assemble(const std::vector<std::string>& headings, const std::vector<Row>& rows, int tile_px)
{
  double names_px = 0;
  for (const Row& row : rows) names_px = std::max(names_px, Canvas::text_width(row.name, kPlain));
  const int left = kEdge_px + static_cast<int>(names_px) + kEdge_px, step = tile_px + kGap_px;
  Canvas canvas(
      std::max(left + static_cast<int>(headings.size()) * step + kGap_px, 700),
      kEdge_px + kHeading_px + static_cast<int>(rows.size()) * step + kLegend_px);
  for (std::size_t c = 0; c < headings.size(); ++c)
    canvas.text(headings[c], left + static_cast<int>(c) * step, kEdge_px + 6, kHeading);
  int y = kEdge_px + kHeading_px;
  for (const Row& row : rows)
  {
    canvas.text(row.name, kEdge_px, y + tile_px / 2.0, kPlain);
    int x = left;
    for (const cv::Mat& tile : row.tiles)
    {
      canvas.paste(tile, x, y);
      canvas.frame({x, y, tile_px, tile_px}, io::kFaintInk);
      x += step;
    }
    y += step;
  }
  return canvas;
}

/** At the foot of a picture. */
void draw_legend(Canvas& canvas, const io::Legend& legend)
{
  const int room = canvas.image().cols - 2 * kEdge_px;
  const int spare = (kLegend_px - legend.height_px(room)) / 2;
  legend.draw(canvas, {kEdge_px, canvas.image().rows - kLegend_px + spare}, room);
}

}  // namespace

void write_maps_picture(const std::string& path, const std::vector<Evaluation>& evaluations)
{
  const int tile_px = evaluations.size() <= kFewRows ? kLargeTile_px : kSmallTile_px;
  const bool truth = std::any_of(
      evaluations.begin(), evaluations.end(), [](const Evaluation& e) { return e.has_truth; });
  std::vector<std::string> headings;
  if (truth) headings.emplace_back("truth");
  std::vector<Row> rows;
  for (const Evaluation& e : evaluations)
  {
    const Snapshot& s = e.snapshot;
    Row row{e.name, {}};
    if (truth) row.tiles.push_back(tile_of(paint_scores(s.true_label, s), s, tile_px));
    for (const auto& [name, map] : s.maps)
    {
      if (rows.empty()) headings.push_back(name);
      row.tiles.push_back(traversability_tile(map, s, tile_px));
    }
    rows.push_back(std::move(row));
  }
  Canvas canvas = assemble(headings, rows, tile_px);
  io::Legend legend;
  legend.colours("blocked", io::colours_of(Palette::Scores), "free");
  legend.swatch(io::palette::kNotJudged);
  legend.swatch(io::palette::kNotSeen);
  draw_legend(canvas, legend);
  io::write_png(path, canvas.image());
}

}  // namespace talus::baselines
