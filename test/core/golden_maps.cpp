#include <gtest/gtest.h>
#include "exact_scene.h"
#include "street.h"

#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <sstream>

// Digests of whole maps, as golden_maps.txt has them: whoever changes a bit of any layer in any of
// these worlds finds out, with every compiler, processor and number of threads.
//
//   test_golden_maps           compares
//   test_golden_maps --write   writes the file anew: for a change that is meant

using namespace talus;
using namespace talus::test;

namespace talus::test
{
/** Whether this processor runs what this executable was compiled for. */
bool can_run();
}  // namespace talus::test

namespace
{
constexpr int kFrames = 30, kEvery = 10;

/** FNV-1a. */
std::uint64_t digest(const void* data, std::size_t bytes)
{
  const auto* at = static_cast<const std::uint8_t*>(data);
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (std::size_t i = 0; i < bytes; i++) hash = (hash ^ at[i]) * 0x100000001b3ull;
  return hash;
}

/** Of the saved map, then of each layer. */
using Digests = std::array<std::uint64_t, 1 + kLayerCount>;

Digests digests_of(const ElevationMapper& map)
{
  Digests all{};
  const auto saved = map.save();
  all[0] = digest(saved.data(), saved.size());
  for (int l = 0; l < kLayerCount; l++)
  {
    const auto& values = map.layer(static_cast<Layer>(l));
    all[static_cast<std::size_t>(1 + l)] = digest(values.data(), values.size() * sizeof(float));
  }
  return all;
}

/** One frame and the memory that it points to. */
struct Step
{
  Scan scan;
  std::vector<float> time_s{};
  std::vector<TimedPose> path{};
  bool restores = false;  //!< before the frame the map is saved, and another goes on
  std::optional<Pose> T_base_sensor{};
  std::uint32_t sensor = 0;

  Frame frame(int i) const
  {
    Frame f = scan.frame(0.1 * i);
    if (!time_s.empty()) f.time_s = time_s.data();
    f.path = path;
    f.T_base_sensor = T_base_sensor;
    f.sensor = sensor;
    return f;
  }
};

struct World
{
  const char* name;
  Parameters parameters;
  std::function<Step(int i, Random& random)> step;
};

ExactScene yard_scene()
{
  ExactScene scene;
  scene.boxes = yard();
  scene.boxes.push_back({{-2.5, -1.5, 0.2}, {-1.7, -0.9, 0.55}});  // a trailer
  return scene;
}

Box walker(double x_m, double y_m) { return {{x_m, y_m, 0}, {x_m + 0.4, y_m + 0.3, 1.4}}; }

/** Times from -0.05 to 0.05 s, the first not known. */
std::vector<float> times_of(const Scan& s)
{
  std::vector<float> times(s.x_.size());
  for (std::size_t k = 0; k < times.size(); k++)
    times[k] = static_cast<float>(k) / static_cast<float>(times.size()) / 10 - 0.05f;
  if (!times.empty()) times[0] = std::numeric_limits<float>::quiet_NaN();
  return times;
}

Parameters with_body(Parameters p, const std::vector<BodyBox>& boxes)
{
  p.body_boxes_m = boxes;
  return p;
}

std::vector<World> worlds()
{
  return {
      {"standing",
       {},
       [](int, Random& r)
       {
         const Pose T = ExactScene::pose(0.01, 0.02, 0.7);
         return Step{yard_scene().scan(T, 360, 24, -0.7, 0.1, r, 0.02)};
       }},
      {"rolling",
       {},
       [](int i, Random& r)
       {
         const Pose T = ExactScene::pose(0.131 * i, 0.04 * i - 0.002 * i * i, 0.7);
         Step s{yard_scene().scan(T, 360, 24, -0.7, 0.1, r, 0.02)};
         spoil(s.scan, r, 0);
         if (i % 13 == 5) s.scan = Scan(T.x(), T.y(), T.z());  // a frame without points
         return s;
       }},
      {"movers",
       {},
       [](int i, Random& r)
       {
         ExactScene scene = yard_scene();
         scene.boxes.push_back(walker(3.5 - 0.15 * i, 1.2));
         if (i < 15) scene.boxes.push_back(walker(1.5, -1.2));  // then it is gone
         const Pose T = ExactScene::pose(0.02 * i, 0, 0.7);
         return Step{scene.scan(T, 360, 32, -0.7, 0.1, r, 0.01)};
       }},
      {"hanging", with({{"clearance_m", 0.8}}),
       [](int i, Random& r)
       {
         ExactScene scene;
         scene.boxes = {{{1, -1, 0.5}, {1.8, 1, 0.55}},   {{2.2, -3, 0.9}, {2.4, 3, 1.0}},
                        {{-2, -2, 0.3}, {-1.2, 2, 0.35}}, {{-2, 1.9, 0}, {-1.9, 2, 0.3}},
                        {{0.5, 2, 1.0}, {3, 3, 1.05}},    {{3, -0.5, 0.2}, {3.5, 0.5, 1.6}}};
         const Pose T = ExactScene::pose(0.05 * i - 0.5, 0.3, 0.75);
         return Step{scene.scan(T, 300, 32, -0.7, 0.35, r, 0.01)};
       }},
      {"ramps_and_a_ditch", with({{"fill_samples", 4}}),
       [](int i, Random& r)
       {
         ExactScene scene;
         scene.profile = {{{-3, 0}},   {{-1, 0.6}}, {{0, 0.6}},   {{0.0625, 0.5}}, {{1.5, 0.5}},
                          {{1.6, -1}}, {{2.1, -1}}, {{2.2, 0.5}}, {{3.5, 0.5}},    {{5, 1.1}}};
         scene.boxes = {walker(2.6, 0.5), walker(-2, -1)};
         const Pose T = ExactScene::pose(0.06 * i - 1, 0.2, 1.25);
         return Step{scene.scan(T, 360, 32, -0.8, 0.1, r, 0.01)};
       }},
      {"deskewed",
       {},
       [](int i, Random& r)
       {
         const double x = 0.08 * i, turn = 0.01 * i;
         const Pose T = ExactScene::pose(x, 0, 0.7, turn);
         Step s{yard_scene().scan(T, 360, 24, -0.7, 0.1, r, 0.01)};
         s.time_s = times_of(s.scan);
         if (i % 3)
           s.path = {
               {-0.05, ExactScene::pose(x - 0.05, 0, 0.7, turn)},
               {0.01, T},
               {0.05, ExactScene::pose(x + 0.04, 0.02, 0.7, turn)}};
         return s;
       }},
      {"tilting_with_voxels_and_a_body",
       with_body(with({{"voxel_m", 0.05}}), {{-0.4, 0.4, -0.3, 0.3, -0.8, 0.1}}),
       [](int i, Random& r)
       {
         const double pitch = (i % 8 < 4 ? i % 4 : 4 - i % 4) * 0.02 - 0.04;
         const Pose T = ExactScene::pose(0.04 * i, -0.1, 0.7, 0.05 * i, pitch);
         return Step{yard_scene().scan(T, 720, 32, -1.5, 0.1, r, 0.01)};
       }},
      {"small_window_that_jumps", with({{"window_m", 2.55}}),
       [](int i, Random& r)
       {
         ExactScene scene = yard_scene();
         scene.boxes.push_back(walker(4 - 0.2 * i, 0.2));
         const double x = i % 10 == 8 ? 500.0 : 0.2 * i, y = i % 14 == 13 ? -1e5 : 0.0;
         Step s{scene.scan(ExactScene::pose(x, y, 0.7), 180, 16, -1.2, 0.1, r, 0.02)};
         spoil(s.scan, r, 0);
         return s;
       }},
      {"wide_window_of_coarse_cells",
       with(
           {{"resolution_m", 0.1},
            {"window_m", 24},
            {"object_size_m", 3.2},
            {"feature_radius_m", 0.4},
            {"fill_search_m", 6}}),
       [](int i, Random& r)
       {
         ExactScene scene = yard_scene();
         scene.profile = {{{-8, -0.5}}, {{-4, 0}}, {{8, 0}}, {{8.1, 0.3}}, {{12, 1.5}}};
         const Pose T = ExactScene::pose(0.31 * i - 5, 0.1 * i - 1, 0.9);
         return Step{scene.scan(T, 720, 48, -0.6, 0.15, r, 0.03)};
       }},
      {"saved_and_restored",
       {},
       [](int i, Random& r)
       {
         ExactScene scene = yard_scene();
         scene.boxes.push_back(walker(3.5 - 0.1 * i, -0.8));
         const Pose T = ExactScene::pose(0.07 * i, 0.03 * i, 0.7, 0.02 * i);
         Step s{scene.scan(T, 360, 24, -0.7, 0.1, r, 0.02)};
         s.restores = i % 7 == 3;
         return s;
       }},
      // One looks down ahead of the robot, the other, beyond an eighth of the window behind its
      // base, is level; both see a box that goes along with it.
      {"two_sensors_on_a_base",
       with_body({}, {{-0.7, -0.3, -0.3, 0.3, 0.1, 0.5}, {0.3, 0.6, -0.2, 0.2, 0.0, 0.3}}),
       [](int i, Random& r)
       {
         const bool ahead = i % 2 == 0;
         const double x = 0.06 * i, along = ahead ? 0.5 : -1.25;
         ExactScene scene = yard_scene();
         scene.boxes.push_back({{x - 0.6, -0.2, 0.2}, {x - 0.4, 0.2, 0.4}});
         const double height = ahead ? 0.8 : 1.1, pitch = ahead ? 0.35 : 0;
         const Pose T = ExactScene::pose(x + along, 0.1, height, 0, pitch);
         Step s{scene.scan(T, 360, 24, -1.2, 0.2, r, 0.01)};
         s.T_base_sensor = ExactScene::pose(along, 0.1, height, 0, pitch);
         s.sensor = ahead ? 0 : 1;
         s.restores = i % 11 == 4;
         return s;
       }}};
}

/** After every tenth frame of a world. */
std::map<std::string, Digests> digests_of(const World& world, int threads)
{
  std::map<std::string, Digests> all;
  Random random(7);
  ElevationMapper map(world.parameters, tested_backend(), threads);
  for (int i = 0; i < kFrames; i++)
  {
    const Step step = world.step(i, random);
    if (step.restores)
    {
      const auto saved = map.save();
      map = ElevationMapper(world.parameters, tested_backend(), threads);
      map.restore(saved);
    }
    map.update(step.frame(i));
    if ((i + 1) % kEvery == 0)
      all[std::string(world.name) + " " + std::to_string(i + 1)] = digests_of(map);
  }
  return all;
}

std::string column_name(std::size_t column)
{
  return column == 0 ? "saved" : kLayerTable[column - 1].name;
}

/** Lines of a name, a frame and the digests; empty where there is no such file. */
std::map<std::string, Digests> read_golden()
{
  std::map<std::string, Digests> all;
  std::ifstream file(TALUS_GOLDEN_MAPS);
  for (std::string line; std::getline(file, line);)
  {
    std::istringstream words(line);
    std::string name, frame;
    Digests digests{};
    words >> name >> frame >> std::hex;
    for (auto& d : digests) words >> d;
    if (words && name[0] != '#') all[name + " " + frame] = digests;
  }
  return all;
}

void write_golden()
{
  std::ofstream file(TALUS_GOLDEN_MAPS);
  file << "# Digests of maps after so many frames; test_golden_maps --write writes this file.\n"
       << "# world frames";
  for (std::size_t c = 0; c <= kLayerCount; c++) file << " " << column_name(c);
  file << "\n";
  for (const World& world : worlds())
    for (const auto& [name, digests] : digests_of(world, 1))
    {
      file << name;
      for (const auto d : digests)
      {
        char hex[17];
        std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(d));
        file << " " << hex;
      }
      file << "\n";
    }
  if (!file.flush()) throw std::runtime_error(TALUS_GOLDEN_MAPS ": cannot be written");
}

class GoldenMaps : public testing::TestWithParam<std::size_t>
{
 protected:
  void SetUp() override
  {
    if (!can_run()) GTEST_SKIP() << "this processor lacks the instructions";
  }
};

void expect_golden(const World& world, int threads)
{
  static const auto golden = read_golden();
  for (const auto& [name, digests] : digests_of(world, threads))
  {
    ASSERT_EQ(golden.count(name), 1u) << name << " is not in " << TALUS_GOLDEN_MAPS;
    for (std::size_t c = 0; c < digests.size(); c++)
      EXPECT_EQ(digests[c], golden.at(name)[c])
          << column_name(c) << " of " << name << " frames has other bits. If that is meant: "
          << "./dev golden writes the digests anew";
  }
}
}  // namespace

TEST_P(GoldenMaps, HasTheSameBitsAsEver) { expect_golden(worlds()[GetParam()], 1); }

TEST_P(GoldenMaps, HasThemWithTwoThreads)
{
  if (tested_backend() != Backend::Cpu) GTEST_SKIP() << "a device has no threads to choose";
  expect_golden(worlds()[GetParam()], 2);
}

INSTANTIATE_TEST_SUITE_P(
    Of, GoldenMaps, testing::Range(std::size_t{0}, worlds().size()),
    [](const auto& world) { return worlds()[world.param].name; });

int main(int argc, char** argv)
{
  if (argc == 2 && std::strcmp(argv[1], "--write") == 0)
  {
    write_golden();
    return 0;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
