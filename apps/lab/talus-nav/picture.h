#pragma once
#include "mission.h"

#include <talus/sim/truth.h>

#include <opencv2/core.hpp>
#include <picture_canvas.h>

#include <functional>
#include <optional>

namespace talus::nav
{
/** Draws a mission over the truth of its world. */
class Painter
{
 public:
  Painter(const sim::World& world, const RobotBody& body, const MissionOptions& options);

  /** Two pictures, one above the other, with a legend below; 8-bit BGR. In both the route, the way
   * driven, the robot, the obstacle points given to the navigator and the goal. Above, the truth
   * and the costmap's obstacles. Below, what the robot knows: its costmap. */
  cv::Mat draw(
      const MissionResult& mission, const Planner& planner, const Pilot& pilot,
      const std::string& title);

 private:
  cv::Point2d pixel(double x_m, double y_m) const;
  void paint_truth(const Planner& planner, double time_s);
  void hatch_below(const sim::Truth& truth);
  using CellColour = std::function<std::optional<cv::Scalar>(float)>;  //!< none: leave it
  void paint_cells(
      cv::Mat& image, const Planner& planner, int side_px, const CellColour& colour_of) const;
  cv::Mat with_mission(
      const cv::Mat& image, const MissionResult& mission, const Planner& planner,
      const Pilot& pilot) const;
  void paint_robot(io::Canvas& canvas, const Step& at) const;

  const sim::World& world_;
  RobotBody body_;
  MissionOptions options_;
  double min_x_m_ = 0, max_y_m_ = 0;
  cv::Mat background_;  //!< the truth without movers
};

}  // namespace talus::nav
