// The snapshot of the map as an observation: what it holds, what a stream keeps of it, and what
// stock rawlog-edit does with it. The log comes from talus-map --rawlog-out.
#include <talus/mrpt/CObservationTraversability.h>

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "message_of.h"
#include "streams.h"
#include "sanitizer.h"
#include "talus_map_run.h"

using namespace talus;
using talus::test::floor_scans;
using talus::test::write_log;
using Snapshot = CObservationTraversability;

namespace
{
/** 4 x 4 m around the base at (1, 2), heading along y; free but for a blocked cell 1.025 m ahead
 * and an unknown quarter. */
Snapshot small_snapshot()
{
  Snapshot s;
  s.timestamp = mrpt::Clock::fromDouble(1000.0);
  s.sensorLabel = "terrain";
  s.T_map_base = mrpt::poses::CPose3D(1, 2, 0.3, M_PI / 2, 0, 0);
  s.window = {80, 0.05, -20, 0};
  std::vector<float> heights(6400, 1.0F), free = heights, state = heights;
  for (int iy = 0; iy < 40; iy++)
    for (int ix = 0; ix < 40; ix++)
    {
      free[80 * iy + ix] = NAN;
      state[80 * iy + ix] = 0;
    }
  free[80 * 60 + 40] = 0;  // its middle is (1.025, 3.025)
  s.set_layer(Layer::Elevation, heights);
  s.set_layer(Layer::GroundElevation, heights);
  s.set_layer(Layer::State, state);
  s.set_layer(Layer::Traversability, free);
  return s;
}

Snapshot through_a_stream(const Snapshot& s, std::size_t* size = nullptr)
{
  const auto bytes = talus_test::bytes_of(s);
  if (size) *size = bytes.size();
  return talus_test::read<Snapshot>(bytes);
}

/** Waves of 0.5 m, and values of every kind. */
constexpr int kScores = static_cast<int>(Layer::Traversability);

Snapshot rich_snapshot()
{
  Snapshot s;
  s.window = {64, 0.05, -1000000, 5};
  std::vector<std::vector<float>> layers(kLayerCount, std::vector<float>(64 * 64, 0.0F));
  for (std::size_t i = 0; i < 64 * 64; i++)
  {
    const auto x = static_cast<float>(i);
    layers[0][i] = i % 7 ? 100 + 0.5F * std::sin(x) : NAN;
    layers[1][i] = -3 + 0.5F * std::cos(x);
    layers[2][i] = 1e-6F * x;
    layers[3][i] = static_cast<float>(i % 4);
    layers[kScores][i] = i % 5 ? x / 4095 : 1e-5F;
  }
  layers[kScores][0] = 0;
  layers[kScores][1] = 1;
  for (std::size_t l = 0; l < layers.size(); l++) s.set_layer(static_cast<Layer>(l), layers[l]);
  return s;
}

/** Runs stock rawlog-edit in the scratch folder with the plugin. */
class RawlogEdit : public talus::test::TalusMap
{
 protected:
  void SetUp() override
  {
    TALUS_SKIP_UNDER_SANITIZER("stock programs are built without it");
    if (std::system("command -v rawlog-edit >/dev/null") != 0)
      GTEST_SKIP() << "rawlog-edit is not installed";
    static const std::string bytes = log_with_snapshots();
    talus::test::write_bytes(path("log.rawlog"), bytes);
  }

  std::string log_with_snapshots() const
  {
    write_log(path("in.rawlog"), floor_scans(6), talus::test::Packing::Gz);
    talus::test::write_bytes(path("in.tum"), talus::test::straight_tum(6));
    runs("in.rawlog --output map --every 2 --rawlog-out log.rawlog --quiet");
    return talus::test::read_bytes(path("log.rawlog"));
  }

  std::string edit(const std::string& arguments) const
  {
    const std::string command = "cd '" + path("") + "' && rawlog-edit -p '" TALUS_PLUGIN "' " +
                                arguments + " </dev/null >edit.txt 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return talus::test::read_bytes(path("edit.txt"));
  }

  /** How many times --info counts scans and snapshots. */
  void expect_counts(const std::string& log, int scans, int snapshots) const
  {
    const std::string info = edit("--info -i " + log);
    EXPECT_EQ(count(info, "lidar"), scans) << info;
    EXPECT_EQ(count(info, "terrain"), snapshots) << info;
  }

  static int count(const std::string& info, const std::string& label)
  {
    std::istringstream text(info);
    for (std::string line; std::getline(text, line);)
      if (line.find("Sensor (") == 0 && line.find(" " + label + " /") != std::string::npos)
        return std::atoi(line.substr(line.find('/', line.find(label)) + 1).c_str());
    return 0;
  }
};

constexpr const char* kFiltersFault =
    "the filters of this rawlog-edit copy what they report as removed";

int lines_of(const std::string& text)
{
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}
}  // namespace

TEST(Snapshot, tells_coverage_and_the_nearest_obstacle_ahead)
{
  const auto s = small_snapshot().summary();
  EXPECT_DOUBLE_EQ(s.coverage(), 0.75);
  EXPECT_DOUBLE_EQ(s.unknown, 0.25);
  EXPECT_DOUBLE_EQ(s.blocked, 1.0 / 6400);
  EXPECT_DOUBLE_EQ(s.free + s.blocked + s.unknown, 1.0);
  EXPECT_NEAR(s.ahead_m, 1.025, 1e-9);
  EXPECT_NEAR(s.nearest_m, std::hypot(1.025, 0.025), 1e-9);
  EXPECT_NEAR(s.nearest_rad, -std::atan2(0.025, 1.025), 1e-9) << "x of the map is its right";
  EXPECT_FLOAT_EQ(static_cast<float>(s.min_ground_m), 1.0F);
}

TEST(Snapshot, without_layers_has_no_numbers_but_does_not_fail)
{
  const Snapshot empty;
  EXPECT_TRUE(std::isnan(empty.summary().nearest_m));
  EXPECT_EQ(empty.summary().unknown, 1.0);
  EXPECT_EQ(through_a_stream(empty).window.cells, 0);
}

TEST(Snapshot, keeps_its_data_in_a_stream_within_what_it_promises)
{
  const Snapshot s = rich_snapshot(), back = through_a_stream(s);
  const auto written = [&](int l, std::size_t i) { return s.layer(static_cast<Layer>(l))[i]; };
  const auto read = [&](int l, std::size_t i) { return back.layer(static_cast<Layer>(l))[i]; };
  EXPECT_EQ(back.window.min_cell_x, s.window.min_cell_x);
  for (std::size_t i = 0; i < 64 * 64; i++)
  {
    ASSERT_EQ(std::isnan(read(0, i)), std::isnan(written(0, i)));
    if (!std::isnan(written(0, i)))
    {
      ASSERT_NEAR(read(0, i), written(0, i), 1.1e-3);
    }
    ASSERT_NEAR(read(1, i), written(1, i), 1.1e-3);
    ASSERT_NEAR(std::sqrt(read(2, i)), std::sqrt(written(2, i)), 2e-3);
    ASSERT_EQ(read(3, i), written(3, i));
    ASSERT_NEAR(read(kScores, i), written(kScores, i), 4e-3);
    ASSERT_EQ(read(kScores, i) == 0, written(kScores, i) == 0) << "what is not blocked stays so";
  }
  EXPECT_EQ(read(kScores, 1), 1.0F);
}

TEST(Snapshot, of_a_map_takes_little_room)
{
  std::size_t bytes = 0;
  const auto s = small_snapshot();
  const auto back = through_a_stream(s, &bytes);
  EXPECT_LT(bytes, 2000U);
  EXPECT_EQ(back.timestamp, s.timestamp);
  EXPECT_EQ(back.sensorLabel, "terrain");
  EXPECT_EQ(back.T_map_base, s.T_map_base);
}

TEST_F(RawlogEdit, describes_the_snapshots)
{
  const auto text = edit("--describe -i log.rawlog");
  for (const char* word :
       {"talus::CObservationTraversability", "Sensor label: 'terrain'", "160 x 160 cells of 0.05 m",
        "elevation, ground_elevation, state, traversability", "% free"})
    EXPECT_TRUE(has(text, word)) << word;
}

TEST_F(RawlogEdit, keeps_or_removes_them_by_label)
{
  if (!talus::detail::kRawlogEditFiltersWork) GTEST_SKIP() << kFiltersFault;
  edit("--keep-label terrain -i log.rawlog -o only.rawlog");
  expect_counts("only.rawlog", 0, 3);
  edit("--remove-label terrain -i log.rawlog -o without.rawlog");
  expect_counts("without.rawlog", 6, 0);
}

TEST_F(RawlogEdit, exports_them_as_a_table)
{
  edit("--export-txt -i log.rawlog");
  const auto text = talus::test::read_bytes(path("log_terrain.txt"));
  ASSERT_EQ(lines_of(text), 4) << text;
  std::istringstream in(text);
  std::string header, row;
  std::getline(in, header);
  std::getline(in, row);
  std::istringstream names(header), values(row);
  std::string percent, name;
  names >> percent;
  std::map<std::string, double> table;
  for (std::string value; names >> name && values >> value;) table[name] = std::stod(value);
  EXPECT_NEAR(table["Time"], talus::test::kFirstStamp_s + 0.1, 1e-5);
  EXPECT_NEAR(table["x_m"], 0.1, 1e-6);
  EXPECT_GT(table["free"], 0.2) << "a floor";
  EXPECT_EQ(table["blocked"], 0.0);
  EXPECT_NEAR(table["ground_max_m"], 0.0, 0.02);
  EXPECT_TRUE(std::isnan(table["ahead_m"]));
}

TEST_F(RawlogEdit, finds_snapshots_in_the_sensory_frames_of_a_log_with_actions)
{
  talus::test::Objects objects;
  for (const auto& scan : floor_scans(3))
  {
    auto frame = std::make_shared<mrpt::obs::CSensoryFrame>();
    frame->insert(std::dynamic_pointer_cast<mrpt::obs::CObservation>(scan));
    objects.push_back(std::make_shared<mrpt::obs::CActionCollection>());
    objects.push_back(frame);
  }
  write_log(path("frames.rawlog"), objects, talus::test::Packing::Plain);
  runs("frames.rawlog --static --rawlog-out out.rawlog --quiet");
  const auto info = edit("--info -i out.rawlog");
  EXPECT_TRUE(has(info, "Actions/SensoryFrame format       : Yes"));
  EXPECT_EQ(count(info, "terrain"), 3);
}

TEST_F(RawlogEdit, a_second_run_replaces_the_snapshots_of_the_first)
{
  runs("log.rawlog --static --rawlog-out again.rawlog --quiet");
  expect_counts("again.rawlog", 6, 6);
}
