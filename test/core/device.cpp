#include <gtest/gtest.h>
#include "scene.h"

#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>

using namespace talus;
using namespace talus::test;

namespace
{
constexpr int kNoDevice = 1023;  // no machine has so many

Scan a_scan()
{
  Scan scan(0, 0, 0.7);
  scan.cast({{{1.5, -0.5, 0}, {1.8, 0.2, 0.4}}}, 90, -0.6, 0.1, 12);
  return scan;
}

std::vector<float> judged(ElevationMapper& map)
{
  const Scan scan = a_scan();
  map.update(scan.frame());
  return map.layer(Layer::Traversability);
}
}  // namespace

TEST(Device, OneThatIsNotThereIsRefusedAndToldHowManyThereAre)
{
  const auto text_for = [](int device)
  {
    try
    {
      const ElevationMapper map({}, Backend::Cuda, 1, device);
    }
    catch (const std::runtime_error& e)
    {
      return std::string(e.what());
    }
    return std::string();
  };
  const std::string only = ": there are only " + std::to_string(cuda_devices()) + " devices";
  EXPECT_EQ(text_for(kNoDevice).rfind("device 1023" + only, 0), 0U) << text_for(kNoDevice);
  EXPECT_NE(text_for(-1).find("device -1"), std::string::npos) << text_for(-1);
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
    {
      const std::string number = "(device " + std::to_string(device) + " of ";
      EXPECT_NE(map.backend_name().find(number), std::string::npos) << map.backend_name();
    }
    std::vector<float> ground;
    std::thread([&] { ground = judged(map); }).join();
    ASSERT_EQ(ground.size(), expected.size());
    EXPECT_EQ(std::memcmp(ground.data(), expected.data(), ground.size() * sizeof(float)), 0)
        << "device " << device;
    std::thread([ended = std::move(map)] {}).join();
  }
}
