#pragma once
#include "mission.h"

#include <opencv2/core.hpp>

namespace talus::nav
{
/** Draws a mission over the truth of its world. */
class Painter
{
 public:
  Painter(const sim::World& world, const RobotBody& body, const MissionOptions& options);

  /** Two pictures, one above the other, each with the route (blue), the way driven (black), the
   * robot (green), the obstacle points given to the navigator (orange) and the goal (cross); 8-bit
   * BGR. Above, the truth: ground by height (grey), what hangs (blue), what blocks (dark), and the
   * costmap's obstacles (red). Below, what the robot knows: its costmap, from traversable (green)
   * to barely (yellow), obstacles (red), unknown (light grey). */
  cv::Mat draw(
      const MissionResult& mission, const Route& route, const Pilot& pilot,
      const std::string& title);

 private:
  cv::Point pixel(double x_m, double y_m) const;
  void paint_truth(const Route& route, double time_s);
  void paint_obstacles(cv::Mat& image, const Route& route) const;
  void paint_costmap(cv::Mat& image, const Route& route) const;
  void paint_mission(
      cv::Mat& image, const MissionResult& mission, const Route& route, const Pilot& pilot) const;
  void paint_robot(cv::Mat& image, const Step& at) const;

  const sim::World& world_;
  RobotBody body_;
  MissionOptions options_;
  double min_x_m_ = 0, max_y_m_ = 0;
  cv::Mat background_;  //!< the truth without movers
};

}  // namespace talus::nav
