#include "picture.h"

#include "legend.h"

#include <talus/sim/truth.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr double kCell_m = 0.05;
constexpr int kPixelsPerCell = 3;
constexpr int kLeastWidth_px = 600;  // of the picture, for its words

const cv::Scalar kRoute(220, 110, 20), kDriven(20, 20, 20), kRobot(60, 150, 30),
    kGoal(160, 20, 160), kPoints(230, 200, 0);
const cv::Scalar kCostmap(70, 70, 230), kJudgedFree(40, 150, 255), kHardly(110, 215, 255),
    kTraversable(110, 215, 105), kUnknown(225, 225, 225);
const cv::Vec3b kBlocked(70, 62, 58);
constexpr int kLowGrey = 150, kHighGrey = 245;

cv::Vec3b below_something(int grey)
{
  return {
      static_cast<unsigned char>(grey), static_cast<unsigned char>(grey - 20),
      static_cast<unsigned char>(grey - 60)};
}

sim::Truth truth_around(
    const sim::World& world, const mrpt::maps::COccupancyGridMap2D& grid, const RobotBody& body,
    double time_s)
{
  const sim::Bounds area{{grid.getXMin(), grid.getYMin(), 0}, {grid.getXMax(), grid.getYMax(), 0}};
  sim::TruthOptions options;
  options.clearance_m = body.height_m;
  options.samples = 3;
  return sim::truth(world, sim::window_around(area, 0, kCell_m), time_s, options);
}

/** Of a cell that is free with this probability; costmap_from_map() says how they are made. */
std::optional<cv::Scalar> costmap_colour(float p)
{
  if (p <= Route::kBlocked) return kCostmap;
  if (p < 0.525F) return kUnknown;  // Route::kHopeful
  if (p < 0.555F) return kJudgedFree;  // traversability 0, and yet no obstacle
  const double t = std::clamp((p - 0.55) / 0.4, 0.0, 1.0);
  return (1 - t) * kHardly + t * kTraversable;
}

std::optional<cv::Scalar> obstacle_colour(float p)
{
  return p <= Route::kBlocked ? std::optional(kCostmap) : std::nullopt;
}

std::vector<std::vector<LegendItem>> legend()
{
  const cv::Scalar hangs(below_something((kLowGrey + kHighGrey) / 2));
  const auto metre_px = static_cast<int>(std::lround(kPixelsPerCell / kCell_m));
  return {
      {{Mark::None, "Above, the truth:"},
       {Mark::Ramp, "ground, low to high", cv::Scalar::all(kLowGrey), cv::Scalar::all(kHighGrey)},
       {Mark::Area, "ground below something", hangs},
       {Mark::Area, "blocked", cv::Scalar(kBlocked)},
       {Mark::Dot, "blocked, as the robot knows", kCostmap}},
      {{Mark::None, "Below, what the robot knows:"},
       {Mark::Ramp, "hardly to well traversable", kHardly, kTraversable},
       {Mark::Area, "blocked", kCostmap},
       {Mark::Area, "looks blocked or is below the robot, taken as free", kJudgedFree},
       {Mark::Area, "unknown", kUnknown}},
      {{Mark::None, "Both:"},
       {Mark::Robot, "robot", kRobot},
       {Mark::Line, "way driven", kDriven},
       {Mark::Line, "route", kRoute},
       {Mark::Dot, "obstacles given to the navigator", kPoints},
       {Mark::Cross, "goal", kGoal},
       {Mark::Bar, "1 m", {}, {}, metre_px}}};
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

cv::Point Painter::pixel(double x_m, double y_m) const
{
  const double scale = kPixelsPerCell / kCell_m;
  return {static_cast<int>((x_m - min_x_m_) * scale), static_cast<int>((max_y_m_ - y_m) * scale)};
}

void Painter::paint_truth(const Route& route, double time_s)
{
  const auto truth = truth_around(world_, route.costmap(), body_, time_s);
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
      const bool hangs = !std::isnan(truth.underside[i]);
      const cv::Vec3b colour = hangs ? below_something(grey) : cv::Vec3b(grey, grey, grey);
      cells.at<cv::Vec3b>(w.cells_y - 1 - iy, ix) = truth.label[i] == 0 ? kBlocked : colour;
    }
  min_x_m_ = w.min_x_m;
  max_y_m_ = w.min_y_m + w.cells_y * w.resolution_m;
  cv::resize(cells, background_, {}, kPixelsPerCell, kPixelsPerCell, cv::INTER_NEAREST);
}

void Painter::paint_robot(cv::Mat& image, const Step& at) const
{
  const double c = std::cos(at.yaw_rad), s = std::sin(at.yaw_rad);
  const double f = 0.5 * body_.length_m, l = 0.5 * body_.width_m;
  std::vector<cv::Point> outline;
  for (const auto& [x, y] : {std::pair{f, l}, {f + 0.12, 0.0}, {f, -l}, {-f, -l}, {-f, l}})
    outline.push_back(pixel(at.x_m + c * x - s * y, at.y_m + s * x + c * y));
  cv::fillPoly(image, std::vector<std::vector<cv::Point>>{outline}, kRobot, cv::LINE_AA);
}

/** Fills a square of this side for each cell of the costmap that has a colour. */
void Painter::paint_cells(
    cv::Mat& image, const Route& route, int side_px, const CellColour& colour_of) const
{
  const auto& grid = route.costmap();
  for (unsigned iy = 0; iy < grid.getSizeY(); iy++)
    for (unsigned ix = 0; ix < grid.getSizeX(); ix++)
    {
      const auto colour = colour_of(grid.getCell(static_cast<int>(ix), static_cast<int>(iy)));
      if (!colour) continue;
      const auto at = pixel(grid.idx2x(ix), grid.idx2y(iy));
      const cv::Rect square =
          cv::Rect(at.x - 1, at.y - 1, side_px, side_px) & cv::Rect(0, 0, image.cols, image.rows);
      image(square).setTo(*colour);
    }
}

void Painter::paint_mission(
    cv::Mat& image, const MissionResult& mission, const Route& route, const Pilot& pilot) const
{
  const Step& at = mission.steps.back();
  std::vector<cv::Point> way, driven;
  for (const auto& p : route.way()) way.push_back(pixel(p.x, p.y));
  for (const auto& s : mission.steps) driven.push_back(pixel(s.x_m, s.y_m));
  cv::polylines(image, way, false, kRoute, 2, cv::LINE_AA);
  cv::polylines(image, driven, false, kDriven, 2, cv::LINE_AA);
  paint_robot(image, at);
  const double c = std::cos(at.yaw_rad), s = std::sin(at.yaw_rad);
  for (std::size_t i = 0; i < pilot.obstacles().size(); i++)
  {
    float x = 0, y = 0;
    pilot.obstacles().getPoint(i, x, y);
    cv::circle(
        image, pixel(at.x_m + c * x - s * y, at.y_m + s * x + c * y), 2, kPoints, cv::FILLED);
  }
  cv::drawMarker(
      image, pixel(options_.goal.x, options_.goal.y), kGoal, cv::MARKER_TILTED_CROSS, 18, 3);
}

cv::Mat Painter::draw(
    const MissionResult& mission, const Route& route, const Pilot& pilot, const std::string& title)
{
  if (background_.empty() || !world_.movers.empty())
    paint_truth(route, mission.steps.back().time_s);
  cv::Mat truth = background_.clone();
  paint_cells(truth, route, 2, obstacle_colour);
  cv::Mat known(truth.size(), truth.type(), kUnknown);
  paint_cells(known, route, kPixelsPerCell, costmap_colour);
  for (cv::Mat* image : {&truth, &known}) paint_mission(*image, mission, route, pilot);
  const int width_px = std::max(truth.cols, kLeastWidth_px);
  cv::Mat all;
  cv::vconcat(
      std::vector<cv::Mat>{
          draw_title(width_px, title), widened(truth, width_px),
          draw_title(width_px, "what the robot knows"), widened(known, width_px),
          draw_legend(width_px, legend())},
      all);
  return all;
}

}  // namespace talus::nav
