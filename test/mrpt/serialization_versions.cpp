// Streams of other versions: a parameter that they leave out has its default, one that they alone
// know is skipped, and a later format is refused by name. The streams are written here byte by
// byte.
#include <talus/mrpt/CObservationTraversability.h>

#include "message_of.h"
#include "room_for_maps.h"
#include "streams.h"

using namespace talus;
using mrpt::serialization::CArchive;
using talus_test::bytes_of;
using talus_test::framed;
using talus_test::read;

namespace
{
/** An empty map, with one known parameter and one that this version does not know. */
void write_map(CArchive& out)
{
  out << mrpt::maps::TMapGenericParams() << std::string("cpu") << std::int32_t(3);
  out << std::uint32_t(2) << std::string("clearance_m") << false << 1.25;
  out << std::string("gone") << false << 7.0;
  out << 0.08 << 0.2 << std::int32_t(5);  // likelihood
  out << true << false << true << std::int32_t(mrpt::img::cmHOT) << std::int32_t(99);  // render
  out << mrpt::poses::CPose3D(1, 2, 3, 0, 0, 0);  // of the robot
  out << std::uint32_t(0) << false << true;  // no sensors; keeps the window only; is empty
}

/** A snapshot without layers but one that this version does not know. */
void write_snapshot(CArchive& out)
{
  out << mrpt::Clock::fromDouble(1000.0) << std::string("terrain")
      << mrpt::poses::CPose3D(1, 2, 0, 0, 0, 0) << mrpt::poses::CPose3D();
  out << std::int32_t(4) << 0.05 << std::int64_t(-2) << std::int64_t(7) << std::uint32_t(1);
  out << std::string("moisture") << 0.0 << 1.0 << std::uint32_t(3);
  out.WriteBuffer("abc", 3);
}

template <class T>
std::string error_of_version(const std::string& name, std::uint8_t version)
{
  return message_of([&] { read<T>(framed(name, version, [](CArchive&) {})); });
}
}  // namespace

TEST(SerializationVersions, a_map_with_fewer_and_other_parameters_is_read)
{
  auto map = read<CDualElevationMap>(framed("talus::CDualElevationMap", 0, write_map));
  EXPECT_TRUE(map.isEmpty());
  EXPECT_EQ(map.insertionOptions.clearance_m, 1.25);
  EXPECT_EQ(map.insertionOptions.resolution_m, Parameters().resolution_m);
  EXPECT_EQ(map.threads(), 3);
  EXPECT_EQ(map.likelihoodOptions.decimation, 5);
  EXPECT_EQ(map.renderOptions.maxCells, 99);
  EXPECT_EQ(map.renderOptions.colormap, mrpt::img::cmHOT);
  EXPECT_TRUE(map.insertObservation(talus_test::scan_of_room({}))) << "and goes on";
}

TEST(SerializationVersions, a_map_of_two_sensors_with_a_body_goes_on_from_a_stream)
{
  const auto see = [](CDualElevationMap& map, int i)
  {
    const mrpt::poses::CPose3D pose(0.1 * i, 0, 0, 0.05 * i, 0.03 * i, 0);
    auto scan = talus_test::scan_of_room(pose);
    scan.sensorLabel = i % 2 ? "rear" : "front";
    return map.insertObservation(scan, pose);
  };
  Parameters p = talus_test::small_window();
  p.body_boxes_m = {{-0.5, 0.1 + 0.2, -0.3, 0.3, 0, 0.9}, {0.3, 0.6, -0.1, 0.1, 0.2, 1.1}};
  CDualElevationMap map(p, Backend::Cpu), copy;
  for (int i = 0; i < 3; i++) ASSERT_TRUE(see(map, i));
  read(bytes_of(map), copy);
  EXPECT_TRUE(
      is_same_value(*find_parameter("body_boxes_m"), copy.insertionOptions, map.insertionOptions));
  for (int i = 4; i > 2; i--)  // the other one first
    for (CDualElevationMap* m : {&map, &copy}) ASSERT_TRUE(see(*m, i));
  EXPECT_EQ(copy.mapper().save(), map.mapper().save());
}

TEST(SerializationVersions, a_snapshot_with_a_layer_of_another_version_is_read_without_it)
{
  const auto snapshot = read<CObservationTraversability>(
      framed("talus::CObservationTraversability", 0, write_snapshot));
  EXPECT_EQ(snapshot.sensorLabel, "terrain");
  EXPECT_EQ(snapshot.window.cells, 4);
  EXPECT_EQ(snapshot.window.min_cell_y, 7);
  EXPECT_TRUE(snapshot.layer(Layer::Elevation).empty());
}

TEST(SerializationVersions, a_later_version_is_refused_with_its_number)
{
  for (const auto& text :
       {error_of_version<CDualElevationMap>("talus::CDualElevationMap", 9),
        error_of_version<CObservationTraversability>("talus::CObservationTraversability", 9)})
    EXPECT_TRUE(has(text, "unknown serialization version number: '9'"));
}
