#include <gtest/gtest.h>
#include "sanitizer.h"
#include "scene.h"
#include "street.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

using namespace talus;
using namespace talus::test;

TEST(Determinism, TheOrderOfThePointsInAFrameDoesNotMatter)
{
  TestMap a, b;
  Random noise(1), order(2);
  for (int i = 0; i < 30; i++)
  {
    const Scan s = drive_frame(i, noise);
    a.update(s);
    b.update(shuffled(s, order));
    expect_same_bits(a.map, b.map, i);
  }
}

TEST(Determinism, TheNumberOfThreadsDoesNotMatter)
{
  TestMap one({}, 1), two({}, 2), sixteen({}, 16);
  Random noise(3);
  for (int i = 0; i < 30; i++)
  {
    const Scan s = drive_frame(i, noise);
    one.update(s);
    two.update(s);
    sixteen.update(s);
    expect_same_bits(one.map, two.map, i);
    expect_same_bits(one.map, sixteen.map, i);
  }
}

TEST(Determinism, LayersAreTheSameWhetherDeliveredOrAskedFor)
{
  TestMap delivered, asked_for, asked_once;
  delivered.map.set_output_layers(
      {Layer::Elevation, Layer::Variance, Layer::Slope, Layer::Sparsity, Layer::Traversability});
  asked_once.map.set_output_layers({Layer::Traversability});
  Random noise(6);
  for (int i = 0; i < 30; i++)
  {
    const Scan s = drive_frame(i, noise);
    delivered.update(s);
    asked_for.update(s);
    asked_once.update(s);
    expect_same_bits(delivered.map, asked_for.map, i);
    if (i == 12) asked_once.map.restore(asked_once.map.save());
  }
  expect_same_bits(delivered.map, asked_once.map, 30);
  EXPECT_EQ(delivered.map.save(), asked_once.map.save());
}

namespace
{
constexpr std::size_t kHeaderBytes = 56, kSensorBytes = 32;

/** Each of two sensors, tilted differently, in turn. */
Frame two_sensors_frame(const Scan& scan, int i)
{
  Frame f = scan.frame(100 + 0.1 * i);
  const double tilt = i % 2 ? 0.3 + 0.01 * i : -0.2;
  f.sensor = i % 2 ? 7 : 0;
  f.T_map_sensor.m[0] = f.T_map_sensor.m[10] = std::cos(tilt);
  f.T_map_sensor.m[2] = std::sin(tilt);
  f.T_map_sensor.m[8] = -std::sin(tilt);
  f.T_base_sensor = translation(i % 2 ? 0.3 : -0.3, 0, 0.7);
  return f;
}
}  // namespace

TEST(Determinism, ARestoredMapOfTwoSensorsGoesOnWithTheSameBits)
{
  TestMap a, b;
  Random noise(9);
  for (int i = 0; i < 9; i++) a.map.update(two_sensors_frame(drive_frame(i, noise), i));
  b.map.restore(a.map.save());
  expect_same_bits(a.map, b.map, 9);
  for (int i = 9; i < 20; i++)
  {
    const Scan s = drive_frame(i, noise);
    a.map.update(two_sensors_frame(s, i));
    b.map.update(two_sensors_frame(s, i));
    expect_same_bits(a.map, b.map, i);
  }
  EXPECT_EQ(a.map.save(), b.map.save());
}

TEST(Determinism, SavedMapsThatAreNoneOrOfAnotherWindowOrDamagedAreRefused)
{
  TestMap m(Scan().add(1, 1, 0)), smaller(with({{"window_m", 4}}));
  const auto sound = m.map.save();
  EXPECT_THROW(smaller.map.restore(sound), std::invalid_argument);
  for (const std::size_t size : {std::size_t{3}, sound.size() - 1})
    EXPECT_THROW(m.map.restore({sound.begin(), sound.begin() + size}), std::invalid_argument);
  EXPECT_THROW(m.map.restore(std::vector<std::uint8_t>(sound.size())), std::invalid_argument);
  const std::size_t cells = m.map.layer(Layer::State).size();
  constexpr std::size_t layers = kHeaderBytes + kSensorBytes;
  const auto refuses = [&](std::size_t at, auto value)
  {
    auto bytes = sound;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    EXPECT_THROW(m.map.restore(bytes), std::invalid_argument) << at;
  };
  refuses(16, std::numeric_limits<std::int64_t>::min());  // where the window lies
  refuses(kHeaderBytes + 8, std::nan(""));  // the axis of the sensor
  refuses(48, std::uint32_t{0});  // how many sensors there are
  refuses(48, std::uint32_t{65});
  refuses(44, INFINITY);  // its height
  refuses(layers, INFINITY);  // the ground
  refuses(layers + 4 * cells, -1.0f);  // its variance
  refuses(layers + 16 * cells, std::uint8_t{4});  // a state
  std::size_t unknown = layers + 16 * cells;
  while (sound[unknown] != 0) unknown++;
  refuses(unknown, std::uint8_t{1});  // a measured cell without a height
  refuses(sound.size() - 4, INFINITY);  // traversability
  EXPECT_EQ(m.state(1, 1), CellState::Measured);
  EXPECT_NO_THROW(m.map.restore(sound));
}

TEST(Determinism, AFrameThatThereIsNoMemoryForLeavesNoTrace)
{
  TALUS_SKIP_UNDER_SANITIZER("it ends the program where memory ends");
  if (tested_backend() != Backend::Cpu) GTEST_SKIP() << "a device has memory of its own";
  TestMap m, other;
  for (TestMap* map : {&m, &other})
  {
    map->map.set_output_layers({Layer::Traversability});
    map->update(Scan().add(1, 1, 0));
  }
  Random noise(8);
  const Scan scan = drive_frame(0, noise);
  Frame huge = scan.frame();
  huge.size = 20'000'000;  // its points are not read before there is room for them
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  rlimit limit = before;  // enough for one of the arrays
  limit.rlim_cur = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + (128 << 20);
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &limit), 0);
  EXPECT_THROW(m.map.update(huge), std::bad_alloc);
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &before), 0);
  expect_same_bits(m.map, other.map, 1);
  for (TestMap* map : {&m, &other}) map->update(scan);
  expect_same_bits(m.map, other.map, 2);
}

TEST(Determinism, ClearForgetsEverything)
{
  TestMap a, fresh;
  Random noise(5);
  a.update(drive_frame(0, noise));
  a.map.clear();
  EXPECT_TRUE(a.map.empty());
  EXPECT_EQ(a.map.save(), fresh.map.save());
}

namespace
{
constexpr int kNoDevice = 1023;  // no machine has so many

std::vector<float> judged(ElevationMapper& map)
{
  const Scan scan = box_ahead();
  map.update(scan.frame());
  return map.layer(Layer::Traversability);
}
}  // namespace

TEST(Device, OneThatIsNotThereIsRefusedAndToldHowManyThereAre)
{
  const auto text_for = [](int device)
  { return message_of([=] { ElevationMapper({}, Backend::Cuda, 1, device); }); };
  const std::string only = ": there are only " + std::to_string(cuda_devices()) + " devices";
  EXPECT_EQ(text_for(kNoDevice).rfind("device 1023" + only, 0), 0U) << text_for(kNoDevice);
  EXPECT_TRUE(has(text_for(-1), "device -1"));
}

TEST(Device, AutoGoesOnWithTheCpuWhereTheDeviceIsNotThere)
{
  const std::string cpu = ElevationMapper({}, Backend::Cpu).backend_name();
  EXPECT_EQ(ElevationMapper({}, Backend::Auto, 1, kNoDevice).backend_name(), cpu);
  EXPECT_EQ(ElevationMapper({}, Backend::Cpu, 1, kNoDevice).backend_name(), cpu);
}

TEST(Device, EachGivesTheSameBitsToWhateverThreadAsks)
{
  ElevationMapper cpu({}, Backend::Cpu);
  const std::vector<float> expected = judged(cpu);
  const int devices = tested_backend() == Backend::Cuda ? cuda_devices() : 0;
  for (int device = 0; device < devices; device++)
  {
    ElevationMapper map({}, Backend::Cuda, 1, device);
    if (devices > 1)
      EXPECT_TRUE(has(map.backend_name(), "(device " + std::to_string(device) + " of "));
    std::vector<float> ground;
    std::thread([&] { ground = judged(map); }).join();
    EXPECT_TRUE(same_bits(ground, expected)) << "device " << device;
    std::thread([ended = std::move(map)] {}).join();
  }
}
