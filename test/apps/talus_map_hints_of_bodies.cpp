// What moves with the robot is told as its body only where it can be nothing else: a pane of glass
// and a person who follows move with the robot, too.
#include "hint_scene.h"

#include <algorithm>

using namespace talus;
using namespace talus::test;

namespace
{
class TalusMapHintsOfBodies : public HintScenes
{
 protected:
  std::map<std::string, int> causes_of(const Scene& scene) const
  {
    write_scene(scene);
    return causes("-s window_m=12");  // beyond where a sensor with no steep beam sees ground
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

TEST_F(TalusMapHintsOfBodies, who_stands_beside_a_robot_at_rest_is_not_suggested)
{
  // Within the reach of a car, so near to its sensor that no ground is seen before them.
  const auto at_rest = [](double) { return Place{0, 0, 0}; };
  for (const double duration_s : {0.1, 8.0})
  {
    Scene scene{at_rest};
    scene.bystander = {{-0.2, 0.2, 1.3, 1.7, 1.65}};
    scene.sensor_m = 1.73;
    scene.duration_s = duration_s;
    write_scene(scene);
    const std::string said = run("drive.rawlog --suggest").out;
    EXPECT_SAYS(said, "\nbody_boxes_m = none  // unknown: ");
  }
}

TEST_F(TalusMapHintsOfBodies, the_body_of_a_car_is_suggested_once_it_has_driven_and_turned)
{
  const std::string mover = real_data("mover.rawlog"), scan = real_data("city_t00.rawlog");
  TALUS_SKIP_WITHOUT(mover);
  EXPECT_SAYS(run(mover + " --suggest").out, "\nbody_boxes_m = -");
  EXPECT_SAYS(run(scan + " --suggest").out, "\nbody_boxes_m = none");
}
