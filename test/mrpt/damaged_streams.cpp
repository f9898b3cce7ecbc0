// Streams that are damaged, made up or of other versions: what they say is refused by name before
// memory is taken for it, and what should have been replaced stays as it was. A parameter that they
// leave out has its default, one that they alone know is skipped. They are written part by part.
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <talus/mrpt/CObservationTraversability.h>
#include <unistd.h>
#include <zlib.h>
#include TALUS_SCENE_HEADER(CSetOfObjects.h)

#include <functional>
#include <limits>
#include <sstream>
#include <utility>

#include "message_of.h"
#include "streams.h"
#include "room_for_maps.h"

using namespace talus;
using mrpt::poses::CPose3D;
using mrpt::serialization::CArchive;
using talus_test::Bytes;
using talus_test::bytes_of;
using talus_test::read;
using Values = std::vector<std::pair<std::string, double>>;

namespace
{
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kLittle_MB = 20;

/** A text whose length is not what it says. */
struct Text
{
  std::string text;
  std::uint32_t size;
  Text(const char* t) : text(t), size(static_cast<std::uint32_t>(text.size())) {}
  Text(const char* t, std::uint32_t s) : text(t), size(s) {}
};
void write(CArchive& out, const Text& t)
{
  out << t.size;
  out.WriteBuffer(t.text.data(), t.text.size());
}

/** All of a map in a stream. */
struct MapParts
{
  std::uint8_t save_as_3d = 1;
  Text backend = "cpu";
  Values parameters;
  std::uint32_t more_parameters = 0;  //!< said, not there
  double sigma_m = 0.05, outlier_ratio = 0.1;
  std::int32_t decimation = 10;
  std::uint8_t show_ground = 1;
  std::int32_t colormap = mrpt::img::cmJET, max_cells = 512;
  double robot_x_m = 0;
  std::uint8_t empty = 1;
  Values of_state;
  std::uint64_t size_of_state = 0;
  Bytes state;

  Bytes bytes() const
  {
    return talus_test::framed(
        "talus::CDualElevationMap", 0,
        [this](CArchive& out)
        {
          mrpt::maps::TMapGenericParams generic;
          std::memcpy(&generic.enableSaveAs3DObject, &save_as_3d, 1);
          out << generic;
          write(out, backend);
          out << std::int32_t(1);
          write_values(out, parameters, more_parameters);
          out << sigma_m << outlier_ratio << decimation << show_ground << std::uint8_t(1)
              << std::uint8_t(1) << colormap << max_cells << CPose3D(robot_x_m, 0, 0, 0, 0, 0)
              << std::uint32_t(0) << std::uint8_t(0) << empty;  // sensors; the whole drive
          if (empty) return;
          write_values(out, of_state, 0);
          out << size_of_state;
          out.WriteBuffer(state.data(), state.size());
        });
  }

 private:
  static void write_values(CArchive& out, const Values& values, std::uint32_t more)
  {
    out << static_cast<std::uint32_t>(values.size() + more);
    for (const auto& [name, value] : values) out << name << std::uint8_t(0) << value;
  }
};

/** Of 20 x 20 cells. */
Values tiny_window() { return {{"window_m", 1}, {"resolution_m", 0.05}}; }

ElevationMapper tiny_mapper()
{
  Parameters p;
  p.window_m = 1;
  ElevationMapper mapper(p, Backend::Cpu);
  const float x = 0.3F, y = 0.2F, z = -0.5F;
  Frame frame;
  frame.x_m = &x, frame.y_m = &y, frame.z_m = &z, frame.size = 1;
  mapper.update(frame);
  return mapper;
}

MapParts tiny_map()
{
  MapParts m;
  m.parameters = m.of_state = tiny_window();
  m.empty = 0;
  m.state = tiny_mapper().save();
  m.size_of_state = m.state.size();
  return m;
}

struct LayerParts
{
  Text name;
  double offset = 0, step = 1.0 / 256;
  Bytes zlib;
};

/** All of a snapshot in a stream. */
struct SnapshotParts
{
  Text label = "terrain";
  double robot_x_m = 0, sensor_x_m = 0;
  std::int32_t cells = 4;
  double resolution_m = 0.05;
  std::int64_t min_cell_x = 0;
  std::uint32_t more_layers = 0;  //!< said, not there
  std::vector<LayerParts> layers;

  Bytes bytes() const
  {
    return talus_test::framed(
        "talus::CObservationTraversability", 0,
        [this](CArchive& out)
        {
          out << mrpt::Clock::fromDouble(1000.0);
          write(out, label);
          out << CPose3D(robot_x_m, 0, 0, 0, 0, 0) << CPose3D(sensor_x_m, 0, 0, 0, 0, 0) << cells
              << resolution_m << min_cell_x << std::int64_t(0)
              << static_cast<std::uint32_t>(layers.size() + more_layers);
          for (const auto& l : layers)
          {
            write(out, l.name);
            out << l.offset << l.step << static_cast<std::uint32_t>(l.zlib.size());
            if (!l.zlib.empty()) out.WriteBuffer(l.zlib.data(), l.zlib.size());
          }
        });
  }
};

/** What a layer of that many cells may be packed in: all zeros. */
Bytes zeros(std::size_t cells)
{
  const Bytes in(2 * cells);
  Bytes out(compressBound(in.size()));
  uLongf size = out.size();
  EXPECT_EQ(compress2(out.data(), &size, in.data(), in.size(), 1), Z_OK);
  out.resize(size);
  return out;
}

template <class T>
std::string refusal(const Bytes& bytes, T& object)
{
  const std::string message = message_of([&] { read(bytes, object); });
  return message == "no error" ? "" : message;
}

template <class T>
std::string refusal(const Bytes& bytes)
{
  T object;
  return refusal(bytes, object);
}

std::string refusal_of(const MapParts& m) { return refusal<CDualElevationMap>(m.bytes()); }
std::string refusal_of(const SnapshotParts& s)
{
  return refusal<CObservationTraversability>(s.bytes());
}

#if defined(TALUS_SANITIZER)
constexpr bool kMeasures = false;  // it keeps memory that was given back
#else
constexpr bool kMeasures = true;
#endif

/** By how much the memory of a child process grows while it does this. */
double growth_MB(const std::function<void()>& what)
{
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0)
  {
    struct rusage before, after;
    getrusage(RUSAGE_SELF, &before);
    what();
    getrusage(RUSAGE_SELF, &after);
    const double MB = static_cast<double>(after.ru_maxrss - before.ru_maxrss) / 1024;
    _exit(::write(ends[1], &MB, sizeof MB) == sizeof MB ? 0 : 1);
  }
  close(ends[1]);
  double MB = kNan;
  EXPECT_EQ(::read(ends[0], &MB, sizeof MB), static_cast<ssize_t>(sizeof MB));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  return kMeasures ? MB : 0;
}

/** Changes each of the first bytes in three ways; cuts the stream at each `step`. */
template <class Use, class UseCut>
void damage_and_cut(
    const Bytes& sound, std::size_t first, std::size_t step, const Use& use, const UseCut& use_cut)
{
  for (std::size_t i = 0; i < first; i++)
    for (const int change : {0xFF, 0x80, 0x01})
    {
      auto bytes = sound;
      bytes[i] = static_cast<std::uint8_t>(bytes[i] ^ change);
      use(bytes);
    }
  for (std::size_t size = 0; size < sound.size(); size += step)
    use_cut({sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(size)});
}

template <class Parts>
void expect_refused_in_little_memory(const Parts& parts, const std::string& why)
{
  EXPECT_TRUE(has(refusal_of(parts), why));
  EXPECT_LT(growth_MB([&] { refusal_of(parts); }), kLittle_MB) << why;
}
}  // namespace

TEST(DamagedMap, a_sound_one_is_read)
{
  CDualElevationMap map;
  EXPECT_EQ(refusal(tiny_map().bytes(), map), "");
  EXPECT_EQ(map.mapper().save(), tiny_mapper().save());
}

TEST(DamagedMap, a_state_of_another_size_than_its_cells_is_refused_before_memory_is_taken_for_it)
{
  auto m = tiny_map();
  for (const std::uint64_t size : {8ULL << 30, 32ULL << 30, 1ULL << 63, 0ULL, 88ULL})
  {
    m.size_of_state = size;
    expect_refused_in_little_memory(m, "size of the state: not that of 20 cells a side");
  }
}

TEST(DamagedMap, a_window_that_its_state_is_none_of_takes_no_memory)
{
  for (const double window_m : {1.1, 300.0, 800.0, 1600.0})
  {
    auto m = tiny_map();
    m.of_state[0].second = window_m;
    expect_refused_in_little_memory(m, window_m < 1000 ? "size of the state" : "window_m = 1600 m");
  }
}

TEST(DamagedMap, bytes_that_never_come_take_no_memory)
{
  auto m = tiny_map();
  m.of_state[0].second = 800;
  Parameters p;
  p.window_m = 800;
  constexpr std::uint64_t kCells = 16000 * 16000, kBytesPerCell = 44;
  m.size_of_state = kBytesPerCell * kCells;
  while (!ElevationMapper::is_size_of_state(m.size_of_state, p)) m.size_of_state++;  // the header
  EXPECT_NE(refusal_of(m), "");
  EXPECT_LT(growth_MB([&] { refusal_of(m); }), kLittle_MB);
}

TEST(DamagedMap, a_state_without_a_frame_in_a_map_that_is_not_empty_is_refused)
{
  auto m = tiny_map();
  Parameters p;
  p.window_m = 1;
  m.state = ElevationMapper(p, Backend::Cpu).save();
  m.size_of_state = m.state.size();
  EXPECT_TRUE(has(refusal_of(m), "size of the state")) << refusal_of(m);
}

TEST(DamagedMap, lengths_of_texts_and_counts_are_not_believed)
{
  MapParts m;
  m.backend = {"cpu", 0xFFFFFFF0};
  expect_refused_in_little_memory(m, "(backend)");
  m = {};
  m.more_parameters = 0xFFFFFFF0;
  expect_refused_in_little_memory(m, "(parameters)");
  m = {};
  m.parameters = {{std::string(101, 'x'), 1}};
  expect_refused_in_little_memory(m, "(parameters)");
}

TEST(DamagedMap, every_parameter_is_checked_and_named)
{
  for (const auto& info : parameter_table())
    for (const double bad :
         {kNan, 2 * std::abs(info.max) + 1, -1e300, info.is_integer ? 0.5 : kNan})
    {
      MapParts m;
      m.parameters = {{info.name, bad}};
      EXPECT_TRUE(has(refusal_of(m), info.name)) << info.name << " " << bad << refusal_of(m);
      m = tiny_map();
      m.of_state.emplace_back(info.name, bad);
      EXPECT_TRUE(has(refusal_of(m), info.name)) << info.name << " " << bad;
    }
  MapParts m;
  m.parameters = {{"weight_step", 0.9}};
  EXPECT_TRUE(has(refusal_of(m), "must be 1, not")) << refusal_of(m);
}

TEST(DamagedMap, every_option_is_checked_and_named)
{
  const auto expect = [](const std::function<void(MapParts&)>& damage, const std::string& why)
  {
    MapParts m;
    damage(m);
    EXPECT_TRUE(has(refusal_of(m), why)) << why << ": " << refusal_of(m);
  };
  expect([](auto& m) { m.backend = "tpu"; }, "backend = 'tpu'");
  expect([](auto& m) { m.save_as_3d = 77; }, "flags of the map");
  expect([](auto& m) { m.sigma_m = kNan; }, "sigma_m = nan");
  expect([](auto& m) { m.outlier_ratio = 0; }, "outlierRatio = 0");
  expect([](auto& m) { m.decimation = 0; }, "decimation = 0");
  expect([](auto& m) { m.show_ground = 2; }, "renderOptions");
  expect([](auto& m) { m.colormap = 77; }, "colormap = 77");
  expect([](auto& m) { m.max_cells = -1; }, "maxCells = -1");
  expect([](auto& m) { m.robot_x_m = kNan; }, "pose of the robot");
  expect([](auto& m) { m.empty = 2; }, "whether it is empty");
}

TEST(DamagedMap, a_map_stays_as_it_was_when_nothing_sound_can_be_read)
{
  auto map = talus_test::map_of_room(1);
  const auto before = map.mapper().save();
  auto m = tiny_map();
  m.state[106] = 0x80;
  m.state[107] = 0x7F;  // the first height behind the header and the sensor: infinite
  EXPECT_TRUE(has(refusal(m.bytes(), map), "its cells are none of a map"));
  auto cut = tiny_map().bytes();
  cut.resize(cut.size() / 2);
  EXPECT_NE(refusal(cut, map), "");
  EXPECT_EQ(map.mapper().save(), before);
  EXPECT_EQ(map.insertionOptions.window_m, talus_test::small_window().window_m);
}

TEST(DamagedMap, any_byte_may_be_wrong_or_missing)
{
  const auto use = [](const Bytes& bytes)
  {
    CDualElevationMap map;
    if (refusal(bytes, map).empty() && !map.isEmpty()) map.asString();
  };
  const auto refuse = [](const Bytes& bytes)
  {
    if (refusal<CDualElevationMap>(bytes).empty()) _exit(1);
  };
  const auto sound = tiny_map().bytes();  // 700 bytes lead on into the cells
  const auto damage = [&] { damage_and_cut(sound, 700, 7, use, refuse); };
  EXPECT_LT(growth_MB(damage), 2 * kLittle_MB);
}

TEST(OptionsSetInCode, are_shown_as_they_are_and_refused_where_they_are_used)
{
  auto map = talus_test::map_of_room(1);
  map.insertionOptions.fill_samples = 77;
  map.renderOptions.colormap = mrpt::img::cmNONE;
  std::stringstream text;
  map.insertionOptions.dumpToTextStream(text);
  map.renderOptions.dumpToTextStream(text);
  EXPECT_TRUE(has(text.str(), "= 77")) << text.str();
  EXPECT_TRUE(has(text.str(), "colormap =  -1")) << text.str();
  EXPECT_FALSE(map.insertObservation(talus_test::scan_of_room({})));
  mrpt_scene::CSetOfObjects scene;
  EXPECT_THROW(map.getVisualizationInto(scene), std::invalid_argument);
  map.renderOptions = {};
  map.renderOptions.maxCells = std::numeric_limits<int>::max();
  EXPECT_THROW(map.getVisualizationInto(scene), std::invalid_argument);
  map.likelihoodOptions.decimation = 0;
  EXPECT_EQ(map.computeObservationLikelihood(talus_test::scan_of_room({}), CPose3D()), 0);
  EXPECT_ANY_THROW(bytes_of(map)) << "it could not be read";
  ObstacleOptions obstacles;
  obstacles.unseen = static_cast<Unseen>(7);
  obstacles.dumpToTextStream(text);
  EXPECT_THROW(classify_cells(map.mapper(), CPose3D(), obstacles), std::invalid_argument);
}

TEST(DamagedSnapshot, has_one_limit_of_its_window_with_the_map)
{
  SnapshotParts s;
  s.cells = kMaxCellsASide;
  EXPECT_EQ(refusal_of(s), "");
  for (const int cells : {kMaxCellsASide + 1, 32768, -1, std::numeric_limits<int>::max()})
  {
    s.cells = cells;
    EXPECT_TRUE(has(refusal_of(s), "number of cells")) << refusal_of(s);
  }
}

TEST(DamagedSnapshot, one_that_is_read_and_told_takes_the_memory_of_its_bytes)
{
  SnapshotParts s;
  s.cells = 2000;  // 16 MB a layer
  const auto packed = zeros(2000 * 2000);
  for (int l = 0; l < kLayerCount; l++) s.layers.push_back({kLayerTable[l].name, 0, 1, packed});
  const auto bytes = s.bytes();
  EXPECT_LT(bytes.size(), 1000000U);
  const auto use = [&]
  {
    CObservationTraversability o;
    read(bytes, o);
    std::stringstream text;
    o.getDescriptionAsText(text);
    text << o.exportTxtDataRow();
    if (bytes_of(o) != bytes) _exit(1);  // as they came
  };
  EXPECT_LT(growth_MB(use), kLittle_MB);
}

TEST(DamagedSnapshot, what_it_says_is_checked_and_named)
{
  const auto expect = [](const std::function<void(SnapshotParts&)>& damage, const std::string& why)
  {
    SnapshotParts s;
    damage(s);
    expect_refused_in_little_memory(s, why);
  };
  expect([](auto& s) { s.label = {"terrain", 0xFFFFFFF0}; }, "label of the sensor");
  expect([](auto& s) { s.robot_x_m = kNan; }, "pose of the robot");
  expect([](auto& s) { s.sensor_x_m = 1 / 0.0; }, "pose of the sensor");
  expect([](auto& s) { s.resolution_m = kNan; }, "side of a cell");
  expect([](auto& s) { s.resolution_m = -1; }, "side of a cell");
  expect([](auto& s) { s.min_cell_x = 1LL << 62; }, "place of the window");
  expect([](auto& s) { s.more_layers = 0xFFFFFFF0; }, "number of layers");
  expect([](auto& s) { s.layers = {{{"x", 0xFFFFFFF0}, 0, 1, {}}}; }, "name of a layer");
  const auto layer = [&](const LayerParts& l)
  { expect([&](auto& s) { s.layers = {l}; }, "layer elevation"); };
  layer({"elevation", 0, 1, {}});
  layer({"elevation", 0, 1, Bytes(2000)});  // more than 16 cells can need
  layer({"elevation", kNan, 1, zeros(16)});
  layer({"elevation", 1e300, 1, zeros(16)});
  layer({"elevation", 0, kNan, zeros(16)});
  layer({"elevation", 0, 1e300, zeros(16)});
  layer({"elevation", 0, 0, zeros(16)});
  expect(
      [](auto& s) {
        s.layers = {{"state", 0, 1, zeros(16)}, {"state", 0, 1, zeros(16)}};
      },
      "layer state twice");
}

TEST(DamagedSnapshot, a_layer_that_its_bytes_are_too_few_for_is_refused)
{
  SnapshotParts s;
  s.cells = kMaxCellsASide;
  s.layers = {{"elevation", 0, 1, zeros(2000 * 2000)}};
  EXPECT_TRUE(has(refusal_of(s), "layer elevation")) << refusal_of(s);
}

TEST(DamagedSnapshot, a_layer_that_is_damaged_inside_throws_where_it_is_unpacked)
{
  auto wrong_sum = zeros(16);
  wrong_sum.back() ^= 1;
  for (const auto& zlib : {zeros(15), zeros(17), Bytes(48), wrong_sum})
  {
    SnapshotParts s;
    s.layers = {{"state", 0, 1, zlib}};
    CObservationTraversability o;
    ASSERT_EQ(refusal(s.bytes(), o), "");
    for (int i = 0; i < 2; i++)
      EXPECT_TRUE(has(message_of([&] { o.layer(Layer::State); }), "the layer state is damaged"));
    EXPECT_THROW(o.summary(), std::runtime_error);
  }
}

TEST(DamagedSnapshot, what_no_cell_can_have_is_unknown)
{
  CObservationTraversability o;
  o.window = {4, 0.05, 0, 0};
  o.set_layer(Layer::State, std::vector<float>(16, 17));
  o.set_layer(Layer::Slope, std::vector<float>(16, 2));
  const auto back = read<CObservationTraversability>(bytes_of(o));
  for (const Layer l : {Layer::State, Layer::Slope})
    for (const float v : back.layer(l)) EXPECT_TRUE(std::isnan(v)) << v;
}

TEST(DamagedSnapshot, stays_as_it_was_when_nothing_sound_can_be_read)
{
  CObservationTraversability o;
  o.window = {4, 0.05, 0, 0};
  o.set_layer(Layer::State, std::vector<float>(16, 2));
  SnapshotParts s;
  s.label = "other";
  s.layers = {{"state", 0, kNan, zeros(16)}};
  EXPECT_NE(refusal(s.bytes(), o), "");
  EXPECT_EQ(o.sensorLabel, "");
  EXPECT_EQ(o.layer(Layer::State), std::vector<float>(16, 2));
}

TEST(DamagedSnapshot, a_layer_that_code_gave_another_size_is_refused)
{
  CObservationTraversability o;
  o.set_layer(Layer::Traversability, {0, 0});
  EXPECT_THROW(o.summary(), std::runtime_error);
  EXPECT_ANY_THROW(bytes_of(o));
}

TEST(DamagedSnapshot, any_byte_may_be_wrong_or_missing)
{
  SnapshotParts s;
  for (int l = 0; l < kLayerCount; l++) s.layers.push_back({kLayerTable[l].name, 0, 1, zeros(16)});
  const auto sound = s.bytes();
  const auto use = [&](const Bytes& bytes)
  {
    CObservationTraversability o;
    if (!refusal(bytes, o).empty()) return;
    message_of(
        [&]
        {
          o.exportTxtDataRow();
          for (int l = 0; l < kLayerCount; l++) o.layer(static_cast<Layer>(l));
        });
  };
  EXPECT_LT(growth_MB([&] { damage_and_cut(sound, sound.size(), 1, use, use); }), kLittle_MB);
}

TEST(SerializationVersions, a_map_with_fewer_and_other_parameters_is_read)
{
  MapParts m;
  m.parameters = {{"clearance_m", 1.25}, {"gone", 7}};
  m.decimation = 5;
  m.max_cells = 99;
  m.colormap = mrpt::img::cmHOT;
  auto map = read<CDualElevationMap>(m.bytes());
  EXPECT_TRUE(map.isEmpty());
  EXPECT_EQ(map.insertionOptions.clearance_m, 1.25);
  EXPECT_EQ(map.insertionOptions.resolution_m, Parameters().resolution_m);
  EXPECT_EQ(map.likelihoodOptions.decimation, 5);
  EXPECT_EQ(map.renderOptions.maxCells, 99);
  EXPECT_EQ(map.renderOptions.colormap, mrpt::img::cmHOT);
  EXPECT_TRUE(map.insertObservation(talus_test::scan_of_room({}))) << "and goes on";
}

TEST(SerializationVersions, a_map_of_two_sensors_with_a_body_goes_on_from_a_stream)
{
  const auto see = [](CDualElevationMap& map, int i)
  {
    const CPose3D pose(0.1 * i, 0, 0, 0.05 * i, 0.03 * i, 0);
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
  SnapshotParts s;
  s.layers = {{"moisture", 0, 1, Bytes(3)}};
  const auto snapshot = read<CObservationTraversability>(s.bytes());
  EXPECT_EQ(snapshot.sensorLabel, "terrain");
  EXPECT_EQ(snapshot.window.cells, 4);
  EXPECT_TRUE(snapshot.layer(Layer::Elevation).empty());
}

TEST(SerializationVersions, a_later_version_is_refused_with_its_number)
{
  const auto of_version_9 = [](const std::string& name)
  { return talus_test::framed(name, 9, [](CArchive&) {}); };
  for (const auto& text :
       {refusal<CDualElevationMap>(of_version_9("talus::CDualElevationMap")),
        refusal<CObservationTraversability>(of_version_9("talus::CObservationTraversability"))})
    EXPECT_TRUE(has(text, "unknown serialization version number: '9'"));
}
