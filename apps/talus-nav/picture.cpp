#include "picture.h"

#include <talus/sim/truth.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr double kCell_m = 0.05;
constexpr int kPixelsPerCell = 3, kTitle_px = 26;

const cv::Scalar kRoute(220, 110, 20), kDriven(20, 20, 20), kRobot(60, 150, 30),
    kGoal(160, 20, 160), kPoints(0, 140, 255), kInk(30, 30, 30);
const cv::Vec3b kBlocked(70, 62, 58), kCostmap(70, 70, 230);

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
cv::Scalar costmap_colour(float p)
{
  if (p < 0.45F) return {70, 70, 230};
  if (std::abs(p - Route::kHopeful) < 0.01F) return cv::Scalar::all(225);
  const double t = std::clamp((p - 0.55) / 0.4, 0.0, 1.0);
  return {110, 215, 255 - 150 * t};
}
}  // namespace

Painter::Painter(const sim::World& world, const RobotBody& body, const MissionOptions& options)
    : world_(world), body_(body), options_(options)
{
}

cv::Point Painter::pixel(double x_m, double y_m) const
{
  const double scale = kPixelsPerCell / kCell_m;
  return {
      static_cast<int>((x_m - min_x_m_) * scale),
      kTitle_px + static_cast<int>((max_y_m_ - y_m) * scale)};
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
      const auto grey = static_cast<unsigned char>(150 + 95 * (truth.ground[i] - *low) / span);
      const bool hangs = !std::isnan(truth.underside[i]);
      cv::Vec3b colour(grey, grey, grey);
      if (hangs)
        colour = {
            grey, static_cast<unsigned char>(grey - 20), static_cast<unsigned char>(grey - 60)};
      cells.at<cv::Vec3b>(w.cells_y - 1 - iy, ix) = truth.label[i] == 0 ? kBlocked : colour;
    }
  min_x_m_ = w.min_x_m;
  max_y_m_ = w.min_y_m + w.cells_y * w.resolution_m;
  cv::Mat large;
  cv::resize(cells, large, {}, kPixelsPerCell, kPixelsPerCell, cv::INTER_NEAREST);
  cv::copyMakeBorder(
      large, background_, kTitle_px, 0, 0, 0, cv::BORDER_CONSTANT, cv::Scalar(255, 255, 255));
}

void Painter::paint_obstacles(cv::Mat& image, const Route& route) const
{
  const auto& grid = route.costmap();
  for (unsigned iy = 0; iy < grid.getSizeY(); iy++)
    for (unsigned ix = 0; ix < grid.getSizeX(); ix++)
    {
      if (grid.getCell(static_cast<int>(ix), static_cast<int>(iy)) > 0.45F) continue;
      const auto at = pixel(grid.idx2x(ix), grid.idx2y(iy));
      const cv::Rect cell =
          cv::Rect(at.x - 1, at.y - 1, 2, 2) & cv::Rect(0, 0, image.cols, image.rows);
      image(cell).setTo(cv::Scalar(kCostmap[0], kCostmap[1], kCostmap[2]));
    }
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

void Painter::paint_costmap(cv::Mat& image, const Route& route) const
{
  const auto& grid = route.costmap();
  for (unsigned iy = 0; iy < grid.getSizeY(); iy++)
    for (unsigned ix = 0; ix < grid.getSizeX(); ix++)
    {
      const auto at = pixel(grid.idx2x(ix), grid.idx2y(iy));
      const cv::Rect cell = cv::Rect(at.x - 1, at.y - 1, kPixelsPerCell, kPixelsPerCell) &
                            cv::Rect(0, kTitle_px, image.cols, image.rows - kTitle_px);
      image(cell).setTo(costmap_colour(grid.getCell(static_cast<int>(ix), static_cast<int>(iy))));
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
  paint_obstacles(truth, route);
  cv::Mat known(truth.size(), truth.type(), cv::Scalar::all(255));
  paint_costmap(known, route);
  const std::array<std::pair<cv::Mat*, std::string>, 2> parts{
      {{&truth, title},
       {&known, "what the robot knows: green to yellow traversable, red blocked, grey unknown"}}};
  for (const auto& [image, text] : parts)
  {
    paint_mission(*image, mission, route, pilot);
    cv::putText(*image, text, {6, 18}, cv::FONT_HERSHEY_SIMPLEX, 0.5, kInk, 1, cv::LINE_AA);
  }
  cv::Mat both;
  cv::vconcat(truth, known, both);
  return both;
}

}  // namespace talus::nav
