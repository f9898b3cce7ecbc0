// What moves with the robot is told as its body only where it can be nothing else: a pane of glass
// and a person who follows move with the robot, too.
#include <functional>

#include "hint_drive.h"

using namespace talus;
using namespace talus::test;

namespace
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

double hit_m(const Ray& ray, const Box& box)
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
  std::vector<Box> pane;  //!< returns rays within 20 degrees of its normal along y only
  bool is_followed = false;  //!< by a person on the robot's way, one metre behind
  double sensor_m = 0.7, lowest_deg = -35;
  double duration_s = 8;
};

constexpr double kBehind_s = 1;  // at 1 m/s

class TalusMapHintsOfBodies : public HintDrive
{
 protected:
  /** The causes that are told of a drive through a scene. */
  std::map<std::string, int> causes_of(const Scene& scene) const
  {
    Objects objects;
    std::string tum;
    for (int i = 0; 0.2 * i < scene.duration_s; ++i)
    {
      const double time_s = 0.2 * i;
      objects.push_back(observation(scene, time_s));
      const Place at = scene.robot(time_s);
      tum += mrpt::format(
          "%.6f %.9f %.9f 0 0 0 %.9f %.9f\n", kFirstStamp_s + time_s, at.x_m, at.y_m,
          std::sin(at.heading_rad / 2), std::cos(at.heading_rad / 2));
    }
    write_log(path("drive.rawlog"), objects, Packing::Plain);
    write_bytes(path("drive.tum"), tum);
    return causes("-s window_m=12");  // beyond where a sensor with no steep beam sees ground
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
    for (const Box& box : boxes) r_m = std::min(r_m, hit_m(ray, box));
    return r_m;
  }

  static mrpt::serialization::CSerializable::Ptr observation(const Scene& scene, double time_s)
  {
    constexpr int kRings = 24, kColumns = 300;
    constexpr double kHighest_deg = 10, kFarthest_m = 30;
    auto obs = observation_at<mrpt::obs::CObservationPointCloud>(kFirstStamp_s + time_s, "lidar");
    auto points = mrpt::maps::CSimplePointsMap::Create();
    const Place at = scene.robot(time_s);
    for (int i = 0; i < kColumns * kRings; ++i)
    {
      const double turn = 2 * M_PI * (i / kRings) / kColumns;
      const double rise = kDegree * (scene.lowest_deg + (kHighest_deg - scene.lowest_deg) *
                                                            (i % kRings) / (kRings - 1));
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
    }
    obs->pointcloud = points;
    obs->sensorPose = CPose3D(0, 0, scene.sensor_m, 0, 0, 0);
    return obs;
  }
};

Place straight_ahead(double time_s) { return {time_s, 0, 0}; }

/** Sways about the x axis at 1 m/s, by 8 degrees to each side. */
Place swaying(double time_s)
{
  constexpr double kSide_m = 0.18, kTurn_rps = 0.8;
  return {
      time_s, kSide_m * std::sin(kTurn_rps * time_s),
      std::atan(kSide_m * kTurn_rps * std::cos(kTurn_rps * time_s))};
}

/** Straight, a quarter of a circle to the left with a radius of 2 m, and straight again. */
Place around_a_corner(double time_s)
{
  constexpr double kRadius_m = 2, kStraight_m = 3;
  const double turned = std::clamp((time_s - kStraight_m) / kRadius_m, 0.0, M_PI / 2);
  const double before_m = std::min(time_s, kStraight_m);
  const double after_m = std::max(0.0, time_s - kStraight_m - kRadius_m * M_PI / 2);
  return {
      before_m + kRadius_m * std::sin(turned), -6 + kRadius_m * (1 - std::cos(turned)) + after_m,
      turned};
}

const std::map<std::string, int> kNone;
}  // namespace

TEST_F(TalusMapHintsOfBodies, a_pane_along_a_straight_way_is_none)
{
  for (const double side_m : {0.5, 1.0, 1.5})
    EXPECT_EQ(causes_of({straight_ahead, {{-2, 10, side_m, side_m + 0.02, 1.8}}}), kNone) << side_m;
}

TEST_F(TalusMapHintsOfBodies, a_pane_beyond_the_reach_of_the_robot_is_none_where_it_sways)
{
  EXPECT_EQ(causes_of({swaying, {{-2, 10, 1.5, 1.52, 1.8}}}), kNone);
}

TEST_F(TalusMapHintsOfBodies, a_pane_within_reach_of_a_robot_that_sways_is_none)
{
  for (const double side_m : {0.6, 0.8})
    EXPECT_EQ(causes_of({swaying, {{-2, 10, side_m, side_m + 0.02, 1.8}}}), kNone) << side_m;
}

TEST_F(TalusMapHintsOfBodies, a_person_who_follows_is_none)
{
  // Of a sensor so high that the person is within its reach; one that sees no ground before them.
  for (const auto& robot : {straight_ahead, swaying, around_a_corner})
    for (const double lowest_deg : {-35, -16})
      EXPECT_EQ(causes_of({robot, {}, true, 1.2, lowest_deg}), kNone) << lowest_deg;
}

TEST_F(TalusMapHintsOfBodies, a_car_seen_from_its_roof_is_one)
{
  const std::string mover = real_data("mover.rawlog");
  TALUS_SKIP_WITHOUT(mover);
  const std::string car =
      " --no-site --output out -s resolution_m=0.1 -s window_m=24 -s min_height_m=-3 "
      "-s max_height_m=0.5 -s clearance_m=1.8";
  EXPECT_EQ(causes_in(run(mover + car).err), only("move with the robot"));
}

TEST_F(TalusMapHintsOfBodies, a_car_seen_in_one_scan_is_suggested)
{
  for (const char* name : {"city_t00", "city_v02", "sparse_t12", "sparse_t30"})
  {
    const std::string log = real_data(std::string(name) + ".rawlog");
    TALUS_SKIP_WITHOUT(log);
    EXPECT_NE(run(log + " --suggest").out.find("\nbody_boxes_m = "), std::string::npos) << name;
  }
}
