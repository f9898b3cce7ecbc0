#include <gtest/gtest.h>
#include <talus/frame_gatherer.h>
#include "scene.h"

#include <stdexcept>

using namespace talus;
using namespace talus::test;

namespace
{
/** One point ahead of a sensor that drives 1 m/s along x. */
class Parts
{
 public:
  Frame operator()(double stamp_s, std::uint32_t sensor = 0)
  {
    Frame f;
    f.stamp_s = stamp_s;
    f.T_map_sensor = translation(stamp_s, 0, 0.5);
    f.sensor = sensor;
    f.x_m = &ahead_m_;
    f.y_m = f.z_m = &beside_m_;
    f.size = 1;
    return f;
  }

 private:
  float ahead_m_ = 3, beside_m_ = 0;
};

/** A gatherer of such parts, and what it passed on. */
struct Gathered
{
  FrameGatherer gatherer;
  Parts part;
  std::vector<double> stamp_s;
  std::vector<std::size_t> points;
  FrameGatherer::Take take = [this](const Frame& scan)
  {
    stamp_s.push_back(scan.stamp_s);
    points.push_back(scan.size);
  };
  void add(const Frame& frame) { gatherer.add(frame, take); }
  void add(double at_s, std::uint32_t sensor = 0) { add(part(at_s, sensor)); }
  void finish() { gatherer.finish(take); }
};

using Counts = std::vector<std::size_t>;

/** The numbers of points of the scans made of frames of one point, so many seconds apart. */
Counts scans_of(int frames, double apart_s, double from_s = 1.7e9)
{
  Gathered scans;
  for (int i = 0; i < frames; i++) scans.add(from_s + apart_s * i);
  return scans.points;
}

TEST(FrameGatherer, PassesOnWholeScansAtOnceAndAsTheyAre)
{
  for (const double apart_s : {1.0, 0.1, 0.067, 0.05, 0.0, -0.01})
    EXPECT_EQ(scans_of(5, apart_s), Counts(5, 1)) << apart_s;
  FrameGatherer gatherer;
  const Frame frame = Parts()(5);
  gatherer.add(
      frame,
      [&](const Frame& scan)
      {
        EXPECT_EQ(&scan, &frame);
        EXPECT_EQ(scan.time_s, nullptr);
      });
}

TEST(FrameGatherer, GathersPartsForTheTimeOfAScan)
{
  EXPECT_EQ(scans_of(31, 0.01), (Counts{1, 10, 10, 10}));
  EXPECT_EQ(scans_of(13, 0.025), (Counts{1, 4, 4, 4}));
  EXPECT_EQ(scans_of(7, 1 / 30.0), (Counts{1, 3, 3}));
  EXPECT_EQ(scans_of(301, 0.001), (Counts{1, 100, 100, 100}));
}

TEST(FrameGatherer, GivesEachPointTheTimeAndThePoseOfItsPart)
{
  FrameGatherer gatherer;
  Parts part;
  Frame moving = part(100.02);
  const float time_s = 0.005f;
  moving.time_s = &time_s;
  moving.path = {{0, translation(1, 0, 0.5)}, {0.008, translation(1.008, 0, 0.5)}};
  std::vector<double> point_s, path_s, path_m;
  const auto take = [&](const Frame& scan)
  {
    if (scan.size < 2) return;
    EXPECT_EQ(scan.stamp_s, 100.1);
    EXPECT_EQ(scan.T_map_sensor.x(), 100.1);
    EXPECT_EQ(scan.x_m[9], 3);
    for (std::size_t i = 0; i < scan.size; i++)
      point_s.push_back(scan.stamp_s + static_cast<double>(scan.time_s[i]));
    for (const TimedPose& p : scan.path)
    {
      path_s.push_back(scan.stamp_s + p.time_s);
      path_m.push_back(p.T_map_sensor.x());
    }
  };
  for (int i = 0; i <= 10; i++) gatherer.add(i == 2 ? moving : part(100 + 0.01 * i), take);
  ASSERT_EQ(point_s.size(), 10u);
  EXPECT_NEAR(point_s[0], 100.01, 1e-6);
  EXPECT_NEAR(point_s[1], 100.025, 1e-6);
  EXPECT_NEAR(point_s[9], 100.1, 1e-6);
  ASSERT_EQ(path_s.size(), 11u);
  EXPECT_NEAR(path_s[2], 100.028, 1e-6);
  EXPECT_EQ(path_m[2], 1.008);
  EXPECT_EQ(path_m[3], 100.03);
}

TEST(FrameGatherer, AfterAGapPartsArePartsAndWholeScansAreWhole)
{
  Gathered bursts;  // five times a second, a tenth of a second each
  for (int burst = 0; burst < 3; burst++)
    for (int i = 0; i < 10; i++) bursts.add(0.2 * burst + 0.01 * i);
  EXPECT_EQ(bursts.points, (Counts{1, 9, 10, 10}));
  Gathered whole;  // one frame comes soon after the one before
  for (const double stamp_s : {0.0, 0.1, 0.13, 0.3, 0.4, 0.5}) whole.add(stamp_s);
  EXPECT_EQ(whole.stamp_s, (std::vector<double>{0, 0.1, 0.13, 0.3, 0.4, 0.5}));
  EXPECT_EQ(whole.points, Counts(6, 1));
}

TEST(FrameGatherer, GathersEachSensorByItself)
{
  Gathered scans;
  for (int i = 0; i <= 10; i++)
    for (const std::uint32_t sensor : {4u, 7u}) scans.add(1 + 0.01 * i + 0.002 * sensor, sensor);
  EXPECT_EQ(scans.points, (Counts{1, 1, 10, 10}));
}

TEST(FrameGatherer, PassesOnTheRestAtTheEnd)
{
  Gathered scans;
  for (int i = 0; i < 4; i++) scans.add(0.01 * i);
  scans.finish();
  scans.finish();
  EXPECT_EQ(scans.points, (Counts{1, 3}));
  EXPECT_EQ(scans.stamp_s.back(), 0.03);
}

TEST(FrameGatherer, GathersNoMorePointsThanAScanHas)
{
  Gathered scans;
  const std::vector<float> many(300000);
  for (int i = 0; i < 9; i++)
  {
    Frame f = scans.part(1 + 1e-6 * i);
    f.x_m = f.y_m = f.z_m = many.data();
    f.size = many.size();
    scans.add(f);
  }
  EXPECT_EQ(scans.points, (Counts{300000, 1200000, 1200000}));
}

TEST(FrameGatherer, TakesNoPartWithoutCoordinates)
{
  Gathered scans;
  scans.add(1);
  Frame broken = scans.part(1.01);
  broken.z_m = nullptr;
  EXPECT_THROW(scans.add(broken), std::invalid_argument);
  broken.size = 0;
  broken.stamp_s = 1.02;
  scans.add(broken);
  scans.finish();
  EXPECT_EQ(scans.points, (Counts{1, 0}));
}
}  // namespace
