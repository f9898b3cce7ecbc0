#include "picture.h"

#include "legend.h"

#include <talus/io/score_colour.h>
#include <talus/sim/truth.h>

#include <opencv2/imgproc.hpp>
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

const cv::Scalar kPoints(66, 228, 240), kKnownBlocked(56, 142, 246), kMayDropColour(160, 60, 120);
const cv::Vec3b kBlocked(70, 62, 58);
constexpr int kLowGrey = 150, kHighGrey = 245;

cv::Scalar score_bgr(double score)
{
  const auto c = io::score_colour(static_cast<float>(score));
  return {static_cast<double>(c[2]), static_cast<double>(c[1]), static_cast<double>(c[0])};
}

/** How well a cell drives that is no obstacle: the better half of the scores. */
cv::Scalar drivable_colour(double traversability) { return score_bgr(0.5 + 0.5 * traversability); }
const cv::Scalar kCostmap = score_bgr(0), kJudgedFree = score_bgr(1.0 / 3);

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
  if (p < kStandsBelow || p == kEdge) return kCostmap;
  if (p <= kBlockedUpTo) return kMayDropColour;
  if (p < 0.525F) return io::kUnknownColour;  // kHopeful
  if (p < 0.555F) return kJudgedFree;  // traversability 0, and yet no obstacle
  return drivable_colour(std::clamp((p - 0.55) / 0.4, 0.0, 1.0));
}

std::optional<cv::Scalar> obstacle_colour(float p)
{
  return p <= kBlockedUpTo ? std::optional(kKnownBlocked) : std::nullopt;
}

cv::Mat ramp(const std::function<cv::Scalar(double)>& colour_of)
{
  cv::Mat column(64, 1, CV_8UC3);
  for (int i = 0; i < column.rows; i++)
    column.row(i).setTo(colour_of(static_cast<double>(i) / (column.rows - 1)));
  return column;
}

std::vector<std::vector<LegendItem>> legend()
{
  const auto grey = [](double part)
  { return cv::Scalar::all(kLowGrey + (kHighGrey - kLowGrey) * part); };
  return {
      {{Mark::None, "The truth:"},
       {Mark::Ramp, "ground, low to high", {}, ramp(grey)},
       {Mark::Hatching, "something hangs above", grey(0.5)},
       {Mark::Area, "blocked", cv::Scalar(kBlocked)},
       {Mark::Dot, "blocked, as the robot knows", kKnownBlocked}},
      {{Mark::None, "What the robot knows:"},
       {Mark::Ramp, "hardly to well traversable", {}, ramp(drivable_colour)},
       {Mark::Area, "blocked", kCostmap},
       {Mark::Area, "may drop, so blocked", kMayDropColour},
       {Mark::Area, "taken as free", kJudgedFree},
       {Mark::Area, "unknown", io::kUnknownColour}},
      {{Mark::None, "Both:"},
       {Mark::Robot, "robot"},
       {Mark::Line, "way driven", io::kInk},
       {Mark::Line, "route", io::kPaper},
       {Mark::Dot, "obstacles given to the navigator", kPoints},
       {Mark::Cross, "goal"}}};
}

/** How long a metre, or a few, are, in the lower left corner. */
void draw_scale_bar(io::Canvas& canvas)
{
  const int length_m = canvas.image().cols > 1500 ? 5 : 2;
  const int length_px = static_cast<int>(std::lround(length_m * kPixelsPerCell / kCell_m));
  const cv::Rect paper(10, canvas.image().rows - 44, length_px + 24, 34);
  const int left = paper.x + 12, y = paper.y + 25;
  canvas.fill(paper, io::kPaper);
  canvas.frame(paper, io::kFaintInk);
  canvas.fill({left, y - 2, length_px, 4}, io::kInk);
  for (const int x : {left, left + length_px - 2}) canvas.fill({x, y - 6, 2, 8}, io::kInk);
  canvas.text(
      std::to_string(length_m) + " m", left + length_px / 2.0, paper.y + 11,
      {10, io::kInk, false, io::Anchor::Middle, io::Anchor::Middle, false});
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
  const auto [low, high] = std::minmax_element(truth.ground.begin(), truth.ground.end());
  const float span = std::max(0.3F, *high - *low);
  cv::Mat cells(w.cells_y, w.cells_x, CV_8UC3);
  for (int iy = 0; iy < w.cells_y; iy++)
    for (int ix = 0; ix < w.cells_x; ix++)
    {
      const auto i = static_cast<std::size_t>(iy * w.cells_x + ix);
      const auto grey = static_cast<unsigned char>(
          kLowGrey + (kHighGrey - kLowGrey) * (truth.ground[i] - *low) / span);
      cells.at<cv::Vec3b>(w.cells_y - 1 - iy, ix) =
          truth.label[i] == 0 ? kBlocked : cv::Vec3b(grey, grey, grey);
    }
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
  draw_way(canvas, way, io::kPaper, io::kInk);
  draw_way(canvas, driven, io::kInk, io::kPaper);
  paint_robot(canvas, at);
  const double c = std::cos(at.yaw_rad), s = std::sin(at.yaw_rad);
  for (std::size_t i = 0; i < pilot.obstacles().size(); i++)
  {
    float x = 0, y = 0;
    pilot.obstacles().getPoint(i, x, y);
    const cv::Point middle(pixel(at.x_m + c * x - s * y, at.y_m + s * x + c * y));
    canvas.fill({middle - cv::Point(2, 2), cv::Size(5, 5)}, kPoints);
  }
  draw_cross(canvas, pixel(options_.goal.x_m, options_.goal.y_m));
  draw_scale_bar(canvas);
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
  cv::Mat known(truth.size(), truth.type(), io::kUnknownColour);
  paint_cells(known, planner, kPixelsPerCell, costmap_colour);
  for (cv::Mat* image : {&truth, &known}) *image = with_mission(*image, mission, planner, pilot);
  const int width_px = std::max(truth.cols, kMinWidth_px);
  cv::Mat all;
  cv::vconcat(
      std::vector<cv::Mat>{
          draw_title(width_px, title + "; the truth"), widened(truth, width_px),
          draw_title(width_px, "What the robot knows"), widened(known, width_px),
          draw_legend(width_px, legend())},
      all);
  return all;
}

}  // namespace talus::nav
