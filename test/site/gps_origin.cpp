// Where a map is on Earth, from the fixes of a receiver and where its antenna was in the map.
#include <gtest/gtest.h>
#include <talus/site/gps_origin.h>

#include <cmath>

#include "log_files.h"

using namespace talus;
using namespace talus::site;

namespace
{
constexpr double kLat_deg = 36.8383, kLon_deg = -2.4045;
/** Metres of a degree of latitude and of longitude there. */
constexpr double kNorth_m = 110968.7, kEast_m = 89230.6;

/** Of a place so far east and north of (kLat_deg, kLon_deg). */
GpsFix fix(double x_m, double y_m, double east_m, double north_m)
{
  return {kLat_deg + north_m / kNorth_m, kLon_deg + east_m / kEast_m, 52, x_m, y_m, 2};
}
}  // namespace

TEST(GpsOrigin, is_where_the_way_of_the_fixes_lies_on_that_of_the_map)
{
  // The map's x axis points 30 degrees north of east; its origin is 100 m east, 50 m north.
  const double c = std::cos(M_PI / 6), s = std::sin(M_PI / 6);
  std::vector<GpsFix> fixes;
  for (const auto& p : {std::pair{0.0, 0.0}, {40.0, 0.0}, {40.0, 30.0}, {-10.0, 25.0}})
    fixes.push_back(
        fix(p.first, p.second, 100 + c * p.first - s * p.second, 50 + s * p.first + c * p.second));
  std::string warning;
  const auto origin = origin_from_fixes(fixes, warning);
  ASSERT_TRUE(origin);
  EXPECT_EQ(warning, "");
  EXPECT_NEAR(origin->heading_deg, 30, 0.01);
  EXPECT_NEAR((origin->latitude_deg - kLat_deg) * kNorth_m, 50, 0.05);
  EXPECT_NEAR((origin->longitude_deg - kLon_deg) * kEast_m, 100, 0.05);
  EXPECT_NEAR(origin->altitude_m, 50, 0.01) << "the antenna was 2 m above the origin of the map";
}

TEST(GpsOrigin, of_a_robot_that_stood_still_has_no_heading_and_says_so)
{
  std::string warning;
  const auto origin = origin_from_fixes({fix(3, 4, 0, 0), fix(4, 4, 2, 3)}, warning);
  ASSERT_TRUE(origin);
  EXPECT_SAYS(warning, "--origin LAT,LON,ALT,HEADING");
  EXPECT_EQ(origin->heading_deg, 0);
  EXPECT_NEAR((origin->latitude_deg - kLat_deg) * kNorth_m, -4, 0.01);
  EXPECT_NEAR((origin->longitude_deg - kLon_deg) * kEast_m, -3, 0.01);
}

TEST(GpsOrigin, warns_where_fixes_and_poses_do_not_go_together)
{
  std::string warning;
  origin_from_fixes({fix(0, 0, 0, 0), fix(50, 0, 10, 0), fix(0, 0, 90, 40)}, warning);
  EXPECT_SAYS(warning, "m off");
  EXPECT_FALSE(origin_from_fixes({}, warning));
}
