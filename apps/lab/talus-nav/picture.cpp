#include "picture.h"

#include <talus/io/palette.h>
#include <talus/sim/truth.h>

#include <opencv2/imgproc.hpp>
#include <picture_legend.h>
#include <picture_relief.h>
#include <picture_style.h>

#include <algorithm>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr double kCell_m = 0.05;
constexpr int kPixelsPerCell = 3;
constexpr int kMinWidth_px = 760;  // of the picture, for its words

namespace palette = io::palette;

/** How well a cell drives that is no obstacle: from hard to free. */
cv::Scalar drivable_colour(double traversability)
{
  return io::bgr(io::score_colour(static_cast<float>(0.3 + 0.7 * traversability)));
}

sim::Truth truth_around(
    const sim::World& world, const Costmap& grid, const RobotBody& body, double time_s)
{
  const sim::Bounds area{
      {grid.min_x_m(), grid.min_y_m(), 0},
      {grid.min_x_m() + grid.columns * grid.resolution_m,
       grid.min_y_m() + grid.rows * grid.resolution_m, 0}};
  sim::TruthOptions options;
  options.clearance_m = body.height_m;
  options.samples = 3;
  return sim::truth(world, sim::window_around(area, 0, kCell_m), time_s, options);
}

/** Of a cell that is free with this probability; costmap_from_map() says how they are made. */
std::optional<cv::Scalar> costmap_colour(float p)
{
  if (p < kStandsBelow) return io::bgr(palette::kStands.rgb);
  if (p == kEdge) return io::bgr(palette::kBlocked.rgb);
  if (p <= kBlockedUpTo) return io::bgr(palette::kMayDrop.rgb);
  if (p < 0.525F) return io::bgr(palette::kNotSeen.rgb);  // kHopeful
  return drivable_colour(std::clamp((p - 0.55) / 0.4, 0.0, 1.0));
}

std::optional<cv::Scalar> obstacle_colour(float p)
{
  return p <= kBlockedUpTo ? std::optional(cv::Scalar(io::bgr(palette::kKnownBlocked.rgb)))
                           : std::nullopt;
}

cv::Mat ramp(const std::function<cv::Scalar(double)>& colour_of)
{
  cv::Mat column(64, 1, CV_8UC3);
  for (int i = 0; i < column.rows; i++)
    column.row(i).setTo(colour_of(static_cast<double>(i) / (column.rows - 1)));
  return column;
}

/** Every fourth diagonal of the pixels is darker where something hangs above. */
bool is_hatched(int x, int y) { return (x + y) % 9 < 2; }

void draw_route(io::Canvas& canvas, const std::vector<cv::Point2d>& route)
{
  if (route.empty()) return;
  canvas.line(route, io::kInk, 6);
  canvas.line(route, io::kPaper, 3);
}

void draw_cross(io::Canvas& canvas, const cv::Point2d& middle)
{
  for (const auto& [colour, width_px] : {std::pair{io::kPaper, 8.0}, {io::kInk, 4.0}})
    for (const cv::Point2d& arm : {cv::Point2d(9, 9), cv::Point2d(9, -9)})
      canvas.line({middle - arm, middle + arm}, colour, width_px);
}

io::Legend legend()
{
  io::Legend legend;
  legend.heading("Ground");
  legend.colours(palette::kHard.name, ramp(drivable_colour), palette::kFree.name);
  for (const auto& c : {palette::kBlocked, palette::kStands, palette::kMayDrop, palette::kNotSeen})
    legend.swatch(c);
  legend.mark(
      {30, 18}, "something hangs above",
      [](io::Canvas& canvas, cv::Point at)
      {
        cv::Mat3b image(18, 30, io::bgr(palette::kFree.rgb));
        for (int y = 0; y < image.rows; y++)
          for (int x = 0; x < image.cols; x++)
            if (is_hatched(x, y)) image(y, x) *= 0.6;
        canvas.paste(image, at.x, at.y);
      });
  legend.new_row();
  legend.heading("Drive");
  legend.robot("robot");
  legend.way_line(palette::kPath.name);
  legend.mark(
      {40, 6}, "route",
      [](io::Canvas& canvas, cv::Point at) {
        draw_route(canvas, {at + cv::Point(0, 3), at + cv::Point(40, 3)});
      });
  legend.mark(
      {20, 20}, "goal",
      [](io::Canvas& canvas, cv::Point at) { draw_cross(canvas, at + cv::Point(10, 10)); });
  for (const auto& c : {palette::kKnownBlocked, palette::kGiven}) legend.swatch(c);
  legend.scale_bar(kPixelsPerCell / kCell_m);
  return legend;
}

/** A white strip with a line of text, made smaller where it would not fit. */
cv::Mat draw_title(int width_px, const std::string& text)
{
  constexpr int kEdge_px = 12, kTitle_px = 40;
  io::TextStyle style{13, io::kInk, true, io::Anchor::Start, io::Anchor::Middle, false};
  style.cap_height_px *=
      std::min(1.0, (width_px - 2 * kEdge_px) / io::Canvas::text_width(text, style));
  io::Canvas strip(width_px, kTitle_px);
  strip.text(text, kEdge_px, kTitle_px / 2.0, style);
  return strip.image();
}

cv::Mat draw_legend(int width_px)
{
  constexpr int kEdge_px = 12;
  const io::Legend all = legend();
  io::Canvas strip(width_px, all.height_px(width_px - 2 * kEdge_px) + 2 * kEdge_px);
  all.draw(strip, {kEdge_px, kEdge_px}, width_px - 2 * kEdge_px);
  return strip.image();
}

/** With paper to its right where it is narrower. */
cv::Mat widened(const cv::Mat& image, int width_px)
{
  cv::Mat wide;
  cv::copyMakeBorder(
      image, wide, 0, 0, 0, std::max(0, width_px - image.cols), cv::BORDER_CONSTANT,
      cv::Scalar::all(255));
  return wide;
}
}  // namespace

Painter::Painter(const sim::World& world, const RobotBody& body, const MissionOptions& options)
    : world_(world), body_(body), options_(options)
{
}

cv::Point2d Painter::pixel(double x_m, double y_m) const
{
  const double scale = kPixelsPerCell / kCell_m;
  return {(x_m - min_x_m_) * scale, (max_y_m_ - y_m) * scale};
}

void Painter::paint_truth(const Planner& planner, double time_s)
{
  const auto truth = truth_around(world_, planner.costmap(), body_, time_s);
  const auto& w = truth.window;
  const auto layer = [&](const std::vector<float>& values)
  {
    cv::Mat1f north_up;
    cv::flip(cv::Mat1f(values, false).reshape(1, w.cells_y), north_up, 0);
    return north_up;
  };
  const cv::Mat1f ground = layer(truth.ground), top = layer(truth.obstacle_top);
  const cv::Mat cells = io::paint_terrain(
      {ground, layer(truth.label), top - ground > io::kMinObstacle_m,
       cv::Mat1b(ground.size(), uchar{2})},
      w.resolution_m);
  min_x_m_ = w.min_x_m;
  max_y_m_ = w.min_y_m + w.cells_y * w.resolution_m;
  cv::resize(cells, background_, {}, kPixelsPerCell, kPixelsPerCell, cv::INTER_NEAREST);
  hatch_below(truth);
}

/** Where something hangs above ground that is free. */
void Painter::hatch_below(const sim::Truth& truth)
{
  const auto& w = truth.window;
  for (int y = 0; y < background_.rows; y++)
    for (int x = 0; x < background_.cols; x++)
    {
      const int row = w.cells_y - 1 - y / kPixelsPerCell;
      const auto i = static_cast<std::size_t>(row * w.cells_x + x / kPixelsPerCell);
      if (is_hatched(x, y) && truth.label[i] != 0 && !std::isnan(truth.underside[i]))
        background_.at<cv::Vec3b>(y, x) *= 0.6;
    }
}

void Painter::paint_robot(io::Canvas& canvas, const Step& at) const
{
  const double c = std::cos(at.yaw_rad), s = std::sin(at.yaw_rad);
  const double f = 0.5 * body_.length_m, l = 0.5 * body_.width_m;
  std::vector<cv::Point2d> outline;
  for (const auto& [x, y] : {std::pair{f, l}, {f + 0.12, 0.0}, {f, -l}, {-f, -l}, {-f, l}})
    outline.push_back(pixel(at.x_m + c * x - s * y, at.y_m + s * x + c * y));
  canvas.polygon(outline, io::kPaper, io::kInk, 1.5);
}

/** Fills a square of this side for each cell of the costmap that has a colour. */
void Painter::paint_cells(
    cv::Mat& image, const Planner& planner, int side_px, const CellColour& colour_of) const
{
  const auto& grid = planner.costmap();
  for (int iy = 0; iy < grid.rows; iy++)
    for (int ix = 0; ix < grid.columns; ix++)
    {
      const auto colour = colour_of(grid.free[grid.index(ix, iy)]);
      if (!colour) continue;
      const auto middle = pixel(
          grid.min_x_m() + (ix + 0.5) * grid.resolution_m,
          grid.min_y_m() + (iy + 0.5) * grid.resolution_m);
      const cv::Point at(static_cast<int>(middle.x), static_cast<int>(middle.y));
      const cv::Rect square =
          cv::Rect(at.x - 1, at.y - 1, side_px, side_px) & cv::Rect(0, 0, image.cols, image.rows);
      image(square).setTo(*colour);
    }
}

cv::Mat Painter::with_mission(
    const cv::Mat& image, const MissionResult& mission, const Planner& planner,
    const Pilot& pilot) const
{
  io::Canvas canvas(image.cols, image.rows);
  canvas.paste(image, 0, 0);
  const Step& at = mission.steps.back();
  std::vector<cv::Point2d> way, driven;
  for (const auto& p : planner.route()) way.push_back(pixel(p.x_m, p.y_m));
  for (const auto& s : mission.steps) driven.push_back(pixel(s.x_m, s.y_m));
  draw_route(canvas, way);
  io::draw_way_line(canvas, driven, 3);
  paint_robot(canvas, at);
  const double c = std::cos(at.yaw_rad), s = std::sin(at.yaw_rad);
  for (std::size_t i = 0; i < pilot.obstacles().size(); i++)
  {
    float x = 0, y = 0;
    pilot.obstacles().getPoint(i, x, y);
    const cv::Point middle(pixel(at.x_m + c * x - s * y, at.y_m + s * x + c * y));
    canvas.fill({middle - cv::Point(2, 2), cv::Size(5, 5)}, io::bgr(palette::kGiven.rgb));
  }
  draw_cross(canvas, pixel(options_.goal.x_m, options_.goal.y_m));
  return canvas.image();
}

cv::Mat Painter::draw(
    const MissionResult& mission, const Planner& planner, const Pilot& pilot,
    const std::string& title)
{
  const int columns = background_.cols / kPixelsPerCell, rows = background_.rows / kPixelsPerCell;
  const bool grew = columns != planner.costmap().columns || rows != planner.costmap().rows;
  if (grew || !world_.movers.empty()) paint_truth(planner, mission.steps.back().time_s);
  cv::Mat truth = background_.clone();
  paint_cells(truth, planner, 2, obstacle_colour);
  cv::Mat known(truth.size(), truth.type(), io::bgr(palette::kNotSeen.rgb));
  paint_cells(known, planner, kPixelsPerCell, costmap_colour);
  for (cv::Mat* image : {&truth, &known}) *image = with_mission(*image, mission, planner, pilot);
  const int width_px = std::max(truth.cols, kMinWidth_px);
  cv::Mat all;
  cv::vconcat(
      std::vector<cv::Mat>{
          draw_title(width_px, title + "; the truth"), widened(truth, width_px),
          draw_title(width_px, "What the robot knows"), widened(known, width_px),
          draw_legend(width_px)},
      all);
  return all;
}

}  // namespace talus::nav
