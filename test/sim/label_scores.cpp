// How labels of points are scored against those of people: by hand-made scans of which each figure
// is known.
#include <gtest/gtest.h>
#include <talus/baselines/real_log.h>

#include <cmath>
#include <limits>

using namespace talus;
using namespace talus::baselines;

namespace
{
using Truth = std::vector<GroundTruth>;

constexpr float kHeight_m = 0.7F;  //!< of the sensor

/** A level floor of 4 x 4 m and a block 0.5 m high beside it, a point in the middle of each cell:
 * of `floor` points, then `block` points. */
struct Scene
{
  static constexpr int kFloor = 40 * 40, kBlock = 10 * 10;
  ScanFrame scan;
  Truth truth;

  explicit Scene(double robot_x_m = 0)
  {
    scan.T_map_sensor.m[3] = robot_x_m;
    scan.T_map_sensor.m[11] = kHeight_m;
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) add(0.1F * (x - 20) + 0.05F, 0.1F * (y - 20) + 0.05F, 0);
    for (int y = 0; y < 10; ++y)
      for (int x = 0; x < 10; ++x) add(0.1F * x + 1.05F, 0.1F * y + 0.05F, 0.5F);
    truth.assign(kFloor, GroundTruth::Ground);
    truth.resize(kFloor + kBlock, GroundTruth::Other);
  }
  void add(float x_m, float y_m, float z_m)
  {
    scan.x_m.push_back(x_m);
    scan.y_m.push_back(y_m);
    scan.z_m.push_back(z_m - kHeight_m);
  }
};

Parameters parameters(double window_m = 8)
{
  Parameters p;
  p.resolution_m = 0.1;
  p.window_m = window_m;
  return p;
}

std::vector<LabelScore> score(const std::vector<Scene>& scenes, double window_m = 8)
{
  Sequence sequence;
  std::vector<Truth> truth;
  for (const Scene& s : scenes) sequence.frames.push_back(s.scan), truth.push_back(s.truth);
  return score_labels(sequence, truth, parameters(window_m), Backend::Cpu);
}
}  // namespace

TEST(LabelScores, TakeTheClassesOfPatchworkPlusPlus)
{
  for (const std::uint32_t ground : {40U, 44U, 48U, 49U, 60U, 72U})
    EXPECT_EQ(ground_truth_of(ground), GroundTruth::Ground) << ground;
  for (const std::uint32_t none : {0U, 1U, 70U})
    EXPECT_EQ(ground_truth_of(none), GroundTruth::NotScored) << none;
  for (const std::uint32_t other : {10U, 30U, 50U, 51U, 52U, 71U, 80U, 99U, 252U, 259U})
    EXPECT_EQ(ground_truth_of(other), GroundTruth::Other) << other;
  EXPECT_EQ(ground_truth_of(0x00030000U | 10U), GroundTruth::Other) << "the third car";
  EXPECT_EQ(ground_truth_of(0xFFFF0000U | 40U), GroundTruth::Ground);
}

TEST(LabelScores, ArePerfectWhereEachPointIsWhatPeopleSay)
{
  const auto scores = score({Scene()});
  ASSERT_EQ(scores.size(), 1U) << "one scan, in a window of less than 24 m";
  EXPECT_EQ(scores[0].scans, 1);
  EXPECT_EQ(scores[0].points, std::uint64_t{Scene::kFloor + Scene::kBlock});
  EXPECT_EQ(scores[0].precision, 1);
  EXPECT_EQ(scores[0].recall, 1);
  EXPECT_EQ(scores[0].f1, 1);
  EXPECT_TRUE(std::isinf(scores[0].within_m));
}

TEST(LabelScores, CountWhatIsWronglySaidAndWhatIsMissed)
{
  Scene scene;
  for (std::size_t i = 0; i < 160; ++i) scene.truth[i] = GroundTruth::Other;  // said to be ground
  for (std::size_t i = 0; i < 40; ++i)
    scene.truth[Scene::kFloor + i] = GroundTruth::Ground;  // said to stand
  for (std::size_t i = 200; i < 300; ++i) scene.truth[i] = GroundTruth::NotScored;
  const LabelScore s = score({scene}).at(0);
  const double right = 1600 - 160 - 100;
  EXPECT_EQ(s.points, 1600U);
  EXPECT_DOUBLE_EQ(s.precision, right / (right + 160));
  EXPECT_DOUBLE_EQ(s.recall, right / (right + 40));
  EXPECT_DOUBLE_EQ(s.f1, 2 * right / (2 * right + 160 + 40));
}

TEST(LabelScores, HaveARowForEachReachThatTheWindowHas)
{
  Scene scene;
  scene.add(13.05F, 0.05F, 0);
  scene.truth.push_back(GroundTruth::Other);
  scene.add(45.05F, 0.05F, 0);  // outside
  scene.truth.push_back(GroundTruth::Other);
  const auto narrow = score({scene}, 28);
  ASSERT_EQ(narrow.size(), 2U);
  EXPECT_EQ(narrow[0].within_m, 12);
  EXPECT_EQ(narrow[0].precision, 1);
  EXPECT_EQ(narrow[1].points, narrow[0].points + 1);
  EXPECT_DOUBLE_EQ(narrow[1].precision, 1600.0 / 1601);
  const auto wide = score({scene}, 80);
  ASSERT_EQ(wide.size(), 3U);
  EXPECT_EQ(wide[1].within_m, 40);
  EXPECT_EQ(wide[2].points, narrow[1].points);
}

TEST(LabelScores, AreMeansOfTheScansInARowAndOfEachAlone)
{
  Scene second(0.5);
  for (std::size_t i = 0; i < 800; ++i) second.truth[i] = GroundTruth::Other;
  Scene without_ground;
  without_ground.truth.assign(without_ground.truth.size(), GroundTruth::Other);
  const auto scores = score({Scene(), second, without_ground});
  ASSERT_EQ(scores.size(), 2U);
  for (const LabelScore& s : scores)
  {
    EXPECT_EQ(s.scans, 2) << "without ground there is no recall";
    EXPECT_DOUBLE_EQ(s.precision, (1 + 0.5) / 2);
    EXPECT_DOUBLE_EQ(s.f1, (1 + 2 * 0.5 / 1.5) / 2);
  }
  EXPECT_FALSE(scores[0].alone);
  EXPECT_TRUE(scores[1].alone);
}

TEST(LabelScores, KnowTheGroundBelowWhatCameLater)
{
  // Alone, a top as wide as a platform is ground; after a scan of the floor below it, it stands.
  Scene floor, top;
  top.scan.x_m.clear(), top.scan.y_m.clear(), top.scan.z_m.clear(), top.truth.clear();
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x)
    {
      const bool on_top = x >= 20 && x < 40 && y >= 20 && y < 40;
      top.add(0.1F * (x - 20) + 0.05F, 0.1F * (y - 20) + 0.05F, on_top ? 0.3F : 0);
      top.truth.push_back(on_top ? GroundTruth::Other : GroundTruth::Ground);
    }
  const auto scores = score({floor, top});
  ASSERT_EQ(scores.size(), 2U);
  EXPECT_EQ(scores[0].precision, 1) << "in a row";
  EXPECT_LT(scores[1].precision, 0.97) << "alone";
}

TEST(LabelScores, OfCellsCountPointsByTheirHeightAboveTheGround)
{
  LabelMap cells;
  cells.stack.resolution_m = 1;
  cells.stack.min_x_m = cells.stack.min_y_m = 0;
  cells.stack.cells_x = 4, cells.stack.cells_y = 1;
  const float none = std::numeric_limits<float>::quiet_NaN();
  cells.stack.names = {"ground", "label"};
  cells.stack.layers = {
      {0, 0.1F, none, 0},
      {LabelMap::kGround, LabelMap::kVegetation, LabelMap::kObstacle, LabelMap::kNotKnown}};
  Scene scene;
  scene.scan.x_m.clear(), scene.scan.y_m.clear(), scene.scan.z_m.clear();
  for (const float x_m : {0.5F, 1.5F, 2.5F, 3.5F, 4.5F, none})
    for (const float z_m : {0.05F, 0.5F}) scene.add(x_m, 0.5F, z_m);
  using G = GroundTruth;
  EXPECT_EQ(
      ground_truth_of(scene.scan, cells),
      (Truth{
          G::Ground, G::Other, G::Ground, G::NotScored, G::Other, G::Other, G::NotScored,
          G::NotScored, G::NotScored, G::NotScored, G::NotScored, G::NotScored}));
}
