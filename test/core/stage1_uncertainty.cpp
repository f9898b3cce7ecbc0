#include <gtest/gtest.h>
#include "scene.h"

using namespace talus;
using namespace talus::test;

TEST(Stage1Uncertainty, AStillSensorGivesTheBeamModelOfEquation3)
{
  Parameters p;
  p.c_beam_m = 0.01, p.a_beam = 0.002;
  TestMap m(p);
  Scan s(0, 0, 0.7);
  s.add(2.02, 1.01, 0.0);
  m.update(s);
  const double l = std::sqrt(2.02 * 2.02 + 1.01 * 1.01 + 0.7 * 0.7);
  const double expected = std::pow(0.01 + 0.002 * l, 2);
  EXPECT_NEAR(m.fused_variance(2.02, 1.01), expected, 1e-5 * expected);
}

TEST(Stage1Uncertainty, ATiltBetweenFramesAddsEquation4)
{
  Parameters p;
  p.c_beam_m = 0.01, p.a_beam = 0.0, p.lambda_t = 1.5;
  TestMap m(p);
  m.update(Scan());
  const double theta = 0.04;
  Scan tilted(0, 0, 0.7);
  tilted.pose_.m = {std::cos(theta),  0, std::sin(theta), 0,  0, 1, 0, 0,
                    -std::sin(theta), 0, std::cos(theta), 0.7};
  tilted.x_ = {2.0f};
  tilted.y_ = {1.0f};
  tilted.z_ = {-0.6f};
  m.update(tilted);
  const double l2 = 2 * 2 + 1 + 0.36;
  const double expected = 1e-4 + std::pow(1.5 * std::sin(theta / 2), 2) * l2;
  const double x = std::cos(theta) * 2 - std::sin(theta) * 0.6;
  EXPECT_NEAR(m.fused_variance(x, 1.001), expected, 1e-4 * expected);
}

TEST(Stage1Uncertainty, AYawBetweenFramesAddsNothing)
{
  Parameters p;
  p.c_beam_m = 0.01, p.a_beam = 0.0;
  TestMap m(p);
  m.update(Scan());
  Scan turned(0, 0, 0.7);
  turned.pose_.m = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.7};
  turned.x_ = {2.01f};
  turned.y_ = {1.01f};
  turned.z_ = {-0.7f};
  m.update(turned);
  EXPECT_NEAR(m.fused_variance(-1.01, 2.01), 1e-4, 1e-9);
}

TEST(Stage1Uncertainty, EachSensorIsComparedWithItsOwnLastFrame)
{
  Parameters p;
  p.c_beam_m = 0.01, p.a_beam = 0.0;
  TestMap m(p);
  const double theta = 0.5;
  Scan level(0, 0, 0.7), tilted(0, 0, 0.7);
  tilted.pose_.m = {std::cos(theta),  0, std::sin(theta), 0,  0, 1, 0, 0,
                    -std::sin(theta), 0, std::cos(theta), 0.7};
  level.x_ = {2.01f};
  level.y_ = {1.01f};
  level.z_ = {-0.7f};
  for (int i = 0; i < 2; i++)
  {
    m.map.update(level.frame());
    Frame other = tilted.frame();
    other.sensor = 3;
    m.map.update(other);
  }
  EXPECT_LT(m.fused_variance(2.01, 1.01), 1.0001e-4);
}

TEST(Stage1Uncertainty, MoreSensorsThanAMapTellsApartAreRefused)
{
  TestMap m;
  Frame f = Scan().frame();
  for (f.sensor = 100; f.sensor < 164; f.sensor++) m.map.update(f);
  const auto before = m.map.save();
  try
  {
    m.map.update(f);
    FAIL() << "a 65th sensor is taken";
  }
  catch (const std::invalid_argument& e)
  {
    EXPECT_NE(std::string(e.what()).find("more than 64 sensors"), std::string::npos) << e.what();
  }
  EXPECT_EQ(m.map.save(), before);
  f.sensor = 120;
  EXPECT_NO_THROW(m.map.update(f));
}
