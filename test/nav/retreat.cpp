// When a robot that stands goes back along its trail.
#include <gtest/gtest.h>
#include <talus/nav/route.h>

namespace
{
using talus::nav::Point2;

/** Asks each 0.1 s. */
struct Drive
{
  talus::nav::Retreat retreat;
  double time_s = 0;

  std::optional<Point2> at(double x_m, double y_m = 0)
  {
    time_s += 0.1;
    return retreat.target(time_s, {x_m, y_m});
  }
  /** From 0 to x along the x axis, at 0.5 m/s. Whether it never went back. */
  bool goes_to(double x_m)
  {
    for (double x = 0; x < x_m; x += 0.05)
      if (at(x)) return false;
    return true;
  }
  std::optional<Point2> stands(double x_m, double seconds)
  {
    std::optional<Point2> back;
    for (int i = 0; i < 10 * seconds && !back; i++) back = at(x_m + (i % 2 ? 0.02 : -0.02));
    return back;
  }
};

TEST(Retreat, goes_on_while_it_moves_and_while_it_waits_a_little)
{
  Drive drive;
  EXPECT_TRUE(drive.goes_to(3));
  EXPECT_FALSE(drive.stands(3, 4.5));
}

TEST(Retreat, goes_back_to_a_place_of_its_trail_and_then_on)
{
  Drive drive;
  ASSERT_TRUE(drive.goes_to(3));
  const auto back = drive.stands(3, 6);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->x_m, 2.15, 0.15);
  EXPECT_DOUBLE_EQ(back->y_m, 0);
  EXPECT_TRUE(drive.at(2.7));
  EXPECT_FALSE(drive.at(back->x_m + 0.2)) << "there";
  EXPECT_FALSE(drive.stands(back->x_m + 0.2, 4)) << "patient again";
}

TEST(Retreat, gives_up_where_it_cannot_go_back)
{
  Drive drive;
  ASSERT_TRUE(drive.goes_to(3));
  ASSERT_TRUE(drive.stands(3, 6));
  int asked = 0;
  while (drive.at(3)) ASSERT_LT(++asked, 70);
  EXPECT_GT(asked, 50);
}

TEST(Retreat, stays_at_the_start_of_its_trail)
{
  Drive drive;
  EXPECT_FALSE(drive.stands(0, 20));
}

TEST(Retreat, does_not_count_the_time_in_which_it_has_nowhere_to_go)
{
  Drive drive;
  ASSERT_TRUE(drive.goes_to(3));
  for (int i = 0; i < 100; i++) drive.retreat.rest(drive.time_s += 0.1);
  EXPECT_FALSE(drive.stands(3, 4.5));
  EXPECT_TRUE(drive.stands(3, 1));
}
}  // namespace
