#pragma once
// Shared by the specifications of hints: what the simulator has not, seen by rays: glass, a person
// who follows, a robot that turns on the spot while a scan is taken, and clocks that are late.
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <functional>

#include "hint_drive.h"

namespace talus::test
{
/** Upright, along the axes of the map. */
struct Box
{
  double min_x_m, max_x_m, min_y_m, max_y_m, max_z_m;
};

struct Ray
{
  double x, y, z;  //!< where it starts, frame of the map
  double dx, dy, dz;
};

inline double hit_m(const Ray& ray, const Box& box)
{
  const std::array<std::array<double, 4>, 3> axes{
      {{ray.x, ray.dx, box.min_x_m, box.max_x_m},
       {ray.y, ray.dy, box.min_y_m, box.max_y_m},
       {ray.z, ray.dz, 0, box.max_z_m}}};
  double from = 0, to = HUGE_VAL;
  for (const auto& [start, step, low, high] : axes)
  {
    if (std::abs(step) < 1e-12 && (start < low || start > high)) return HUGE_VAL;
    if (std::abs(step) < 1e-12) continue;
    const double a = (low - start) / step, b = (high - start) / step;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from < to && from > 0 ? from : HUGE_VAL;
}

/** A robot's place: on the floor. */
struct Place
{
  double x_m, y_m, heading_rad;
};

/** A level floor between two walls, and what is special about it. */
struct Scene
{
  std::function<Place(double time_s)> robot;
  std::vector<Box> pane{};  //!< returns rays within 20 degrees of its normal along y only
  bool is_followed = false;  //!< by a person on the robot's way, one metre behind
  double sensor_m = 0.7, lowest_deg = -35;
  double duration_s = 8, step_s = 0.2;
  double sweep_s = 0;  //!< from the first ray of a scan to the last; they are told as one moment
  bool has_times = false, has_times_backwards = false;  //!< of the rays
  double late_s = 0;  //!< of the stamps of the scans
  std::vector<Box> bystander{};
};

constexpr double kBehind_s = 1;  // at 1 m/s

class HintScenes : public HintDrive
{
 protected:
  /** drive.rawlog and drive.tum of a drive through a scene. */
  void write_scene(const Scene& scene) const
  {
    Objects objects;
    std::string tum;
    for (int i = 0; scene.step_s * i < scene.duration_s; ++i)
    {
      const double time_s = scene.step_s * i;
      objects.push_back(observation(scene, time_s));
      const Place at = scene.robot(time_s);
      tum += mrpt::format(
          "%.6f %.9f %.9f 0 0 0 %.9f %.9f\n", kFirstStamp_s + time_s, at.x_m, at.y_m,
          std::sin(at.heading_rad / 2), std::cos(at.heading_rad / 2));
    }
    write_log(path("drive.rawlog"), objects, Packing::Plain);
    write_bytes(path("drive.tum"), tum);
  }

 private:
  static double range_m(const Scene& scene, const Ray& ray, double time_s)
  {
    double r_m = ray.dz < -1e-6 ? -ray.z / ray.dz : HUGE_VAL;
    std::vector<Box> boxes{{-16, 24, 5, 5.2, 2}, {-16, 24, -9, -8.8, 2}, {20, 20.2, -9, 5, 2}};
    if (scene.is_followed)
    {
      const Place at = scene.robot(time_s - kBehind_s);
      boxes.push_back({at.x_m - 0.2, at.x_m + 0.2, at.y_m - 0.2, at.y_m + 0.2, 1.7});
    }
    if (std::abs(ray.dy) > std::cos(20 * kDegree))
      boxes.insert(boxes.end(), scene.pane.begin(), scene.pane.end());
    boxes.insert(boxes.end(), scene.bystander.begin(), scene.bystander.end());
    for (const Box& box : boxes) r_m = std::min(r_m, hit_m(ray, box));
    return r_m;
  }

  static mrpt::serialization::CSerializable::Ptr observation(const Scene& scene, double time_s)
  {
    constexpr int kRings = 24, kColumns = 300;
    constexpr double kHighest_deg = 10, kFarthest_m = 30;
    const double stamp_s = kFirstStamp_s + time_s + scene.late_s;
    auto obs = observation_at<mrpt::obs::CObservationPointCloud>(stamp_s, "lidar");
    auto timed = observation_at<mrpt::obs::CObservationVelodyneScan>(stamp_s, "lidar");
    auto points = mrpt::maps::CSimplePointsMap::Create();
    for (int i = 0; i < kColumns * kRings; ++i)
    {
      const double turn = 2 * M_PI * (i / kRings) / kColumns;
      const double rise = kDegree * (scene.lowest_deg + (kHighest_deg - scene.lowest_deg) *
                                                            (i % kRings) / (kRings - 1));
      const double ray_s = time_s + scene.sweep_s * turn / (2 * M_PI);
      const Place at = scene.robot(ray_s);
      const double ahead = turn + at.heading_rad;
      const double r_m = range_m(
          scene,
          {at.x_m, at.y_m, scene.sensor_m, std::cos(rise) * std::cos(ahead),
           std::cos(rise) * std::sin(ahead), std::sin(rise)},
          time_s);
      if (r_m > kFarthest_m) continue;
      points->insertPoint(
          static_cast<float>(r_m * std::cos(rise) * std::cos(turn)),
          static_cast<float>(r_m * std::cos(rise) * std::sin(turn)),
          static_cast<float>(r_m * std::sin(rise)));
      const double passed_s =
          scene.has_times_backwards ? scene.sweep_s - (ray_s - time_s) : ray_s - time_s;
      timed->point_cloud.timestamp.push_back(mrpt::Clock::fromDouble(stamp_s + passed_s));
    }
    obs->pointcloud = points;
    timed->minRange = 0;
    auto& cloud = timed->point_cloud;
    points->getAllPoints(cloud.x, cloud.y, cloud.z);
    cloud.intensity.assign(cloud.x.size(), 0);
    cloud.laser_id.assign(cloud.x.size(), 0);
    obs->sensorPose = timed->sensorPose = CPose3D(0, 0, scene.sensor_m, 0, 0, 0);
    if (scene.has_times) return timed;
    return obs;
  }
};

}  // namespace talus::test
