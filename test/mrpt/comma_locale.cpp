// What talus reads and writes in a program whose locale has a decimal comma: the same bytes as in
// any other.
#include <mrpt/config/CConfigFileMemory.h>
#include <talus/io/geotiff.h>
#include <talus/io/summary_json.h>
#include <talus/io/trajectory.h>
#include <talus/mrpt/CObservationTraversability.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>
#include <talus/sim/world.h>
#include <unistd.h>

#include <clocale>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <locale>
#include <regex>
#include <sstream>

#include "message_of.h"
#include "room_for_maps.h"

using namespace talus;
using mrpt::config::CConfigFileMemory;

namespace
{
/** A locale with a decimal comma and groups of digits, which a program with windows takes over from
 * the desktop. */
class CommaLocale : public testing::Test
{
 protected:
  void SetUp() override
  {
    setenv("LOCPATH", TALUS_TEST_LOCALES, 1);
    constexpr const char* name = "de_DE.UTF-8";
    if (!std::setlocale(LC_ALL, name))
      GTEST_SKIP() << "there is no locale with a decimal comma: install the Debian package locales "
                      "and configure again";
    std::locale::global(std::locale(name));
    ASSERT_EQ(std::strtod("0.5", nullptr), 0) << "a point ends a number here";
  }
  void TearDown() override
  {
    std::locale::global(std::locale::classic());
    std::setlocale(LC_ALL, "C");
  }
};

/** `0,05` anywhere. */
bool has_comma_number(const std::string& text)
{
  return std::regex_search(text, std::regex(R"(\d,\d\d)"));
}

template <typename Options>
Options saved_and_loaded(const Options& options, std::string& text)
{
  CConfigFileMemory memory;
  options.saveToConfigFile(memory, "Section");
  text += memory.getContent();
  Options loaded;
  loaded.loadFromConfigFile(memory, "Section");
  return loaded;
}

/** A file of this process, removed at the end. */
struct File
{
  explicit File(const std::string& ending)
      : path((std::filesystem::temp_directory_path() /
              ("talus_comma_" + std::to_string(getpid()) + ending))
                 .string())
  {
  }
  ~File() { std::filesystem::remove(path); }
  const std::string path;
};

io::LayerStack one_cell()
{
  io::LayerStack s;
  s.cells_x = s.cells_y = 1;
  s.resolution_m = 0.05;
  s.min_x_m = -1.25;
  s.names = {"elevation"};
  s.layers = {{1.5F}};
  return s;
}
}  // namespace

TEST_F(CommaLocale, numbers_have_a_point)
{
  EXPECT_EQ(number_from("0.10"), 0.1);
  EXPECT_EQ(number_from("0,10"), std::nullopt);
  EXPECT_EQ(number_text(1234.5), "1234.5");
  EXPECT_EQ(fixed_text(1234567.125, 2), "1234567.12");
  Parameters p;
  set_parameter(p, "resolution_m", "0.10");
  EXPECT_EQ(p.resolution_m, 0.1);
  EXPECT_EQ(parameter_text(p, *find_parameter("resolution_m")), "0.1");
}

TEST_F(CommaLocale, options_go_through_an_ini_file_and_back)
{
  CDualElevationMap::TInsertionOptions insertion;
  insertion.clearance_m = 0.75;
  CDualElevationMap::TLikelihoodOptions likelihood;
  likelihood.sigma_m = 0.125;
  CDualElevationMap::TRenderOptions render;
  render.maxCells = 12345;
  ObstacleOptions obstacles;
  obstacles.seen_within_m = 1.25;
  std::string text;
  EXPECT_EQ(saved_and_loaded(insertion, text).clearance_m, 0.75);
  EXPECT_EQ(saved_and_loaded(likelihood, text).sigma_m, 0.125);
  EXPECT_EQ(saved_and_loaded(render, text).maxCells, 12345);
  EXPECT_EQ(saved_and_loaded(obstacles, text).seen_within_m, 1.25);
  EXPECT_FALSE(has_comma_number(text)) << text;
  EXPECT_TRUE(has(parameters_as_markdown(), "| 0.05 | m | 0.001 to 100 |"));
}

TEST_F(CommaLocale, a_map_and_a_snapshot_tell_numbers_with_points)
{
  const auto map = talus_test::map_of_room(1);
  EXPECT_TRUE(has(map.asString(), "6 x 6 m at 0.05 m from (-3.00,-3.00), 14400 of"))
      << map.asString();
  std::stringstream text;
  map.insertionOptions.dumpToTextStream(text);
  map.likelihoodOptions.dumpToTextStream(text);
  EXPECT_FALSE(has_comma_number(text.str())) << text.str();
  const CObservationTraversability snapshot(map.mapper(), mrpt::poses::CPose3D(0.5, 0, 0, 0, 0, 0));
  EXPECT_TRUE(has(snapshot.exportTxtDataRow(), "     0.500000 "));
  EXPECT_FALSE(has(snapshot.exportTxtDataRow(), ",")) << snapshot.exportTxtDataRow();
}

TEST_F(CommaLocale, tables_and_summaries_have_points)
{
  FrameReport frame;
  frame.stamp_s = 1234.5;
  frame.total_ms = 0.25;
  frame.points_in = 100000;
  const auto csv = io::timing_csv({frame});
  EXPECT_TRUE(has(csv, "\n1234.500000,100000,0,")) << csv;
  EXPECT_TRUE(has(csv, ",0.2500\n")) << csv;
  io::RunSummary run;
  run.wall_s = 0.5;
  EXPECT_TRUE(has(io::summary_json(run, one_cell()), "\"wall_seconds\": 0.5"));
}

TEST_F(CommaLocale, a_geotiff_keeps_its_place)
{
  const File file(".tif");
  io::write_geotiff(file.path, one_cell());
  const auto back = io::read_geotiff(file.path);
  EXPECT_DOUBLE_EQ(back.min_x_m, -1.25);
  EXPECT_DOUBLE_EQ(back.resolution_m, 0.05);
  EXPECT_EQ(back.layers, one_cell().layers);
}

TEST_F(CommaLocale, a_trajectory_is_read)
{
  const File file(".tum");
  std::ofstream(file.path) << "1000.25 0.5 +1.5 0 0 0 0 1\n";
  const auto trajectory = io::Trajectory::load(file.path);
  ASSERT_EQ(trajectory.entries().size(), 1U);
  EXPECT_EQ(trajectory.entries()[0].time_s, 1000.25);
  EXPECT_EQ(trajectory.entries()[0].T_map_base.y(), 1.5);
}

TEST_F(CommaLocale, a_world_is_read)
{
  const auto world = sim::load_world(TALUS_SOURCE_DIR "/datasets/worlds/demo.yaml");
  std::locale::global(std::locale::classic());
  std::setlocale(LC_ALL, "C");
  const auto same = sim::load_world(TALUS_SOURCE_DIR "/datasets/worlds/demo.yaml");
  EXPECT_EQ(world.robot.speed_mps, same.robot.speed_mps);
  EXPECT_EQ(world.robot.duration_s, same.robot.duration_s);
  EXPECT_EQ(world.sensors[0].T_base_sensor.m, same.sensors[0].T_base_sensor.m);
  EXPECT_NE(same.sensors[0].T_base_sensor.z(), std::floor(same.sensors[0].T_base_sensor.z()));
  EXPECT_EQ(world.ground.height_m(1.5, 2.5), same.ground.height_m(1.5, 2.5));
}
