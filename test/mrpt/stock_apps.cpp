// Stock programs of Debian's mrpt-apps with the plugin preloaded and the shipped configurations:
// what they write, and what they say about mistakes. Links no talus.
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "log_files.h"
#include "sanitizer.h"

namespace
{
namespace fs = std::filesystem;
const std::string kConfigs = TALUS_SOURCE_DIR "/datasets/configs/";

class StockApps : public testing::Test
{
 protected:
  void SetUp() override { TALUS_SKIP_UNDER_SANITIZER("stock programs are built without it"); }

  /** Runs a program in the scratch folder; no window, no key. The exit code, or -1 for a crash or
   * where it did not end. */
  int run(const std::string& program, const std::string& arguments, int copies = 1)
  {
    std::string preload = TALUS_PLUGIN;
    if (copies == 2)
    {
      fs::copy_file(TALUS_PLUGIN, path("second.so"));
      preload += ":" + path("second.so");
    }
    const std::string line = "cd '" + path("") + "' && LD_PRELOAD='" + preload + "' timeout 280 " +
                             program + " " + arguments + " </dev/null >output.txt 2>&1";
    const int status = std::system(line.c_str());
    output = talus::test::read_bytes(path("output.txt"));
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return code >= 124 && code < 160 ? -1 : code;  // 124: out of time, 128 + n: by signal n
  }

  bool installed(const std::string& program, const std::string& data) const
  {
    return std::system(("command -v " + program + " >/dev/null").c_str()) == 0 &&
           !talus::test::stock_dataset(data).empty();
  }

  std::string path(const std::string& name) const { return dir_ / name; }

  /** The terrain map's files below a folder, by ending: GeoTIFF, picture, scene, once each. */
  void expect_terrain_map(const std::string& folder, const std::string& stem) const
  {
    int maps = 0;
    for (const auto& entry : fs::recursive_directory_iterator(path(folder)))
    {
      const auto name = entry.path().filename().string();
      if (name.rfind(stem, 0) != 0 || name.find("CDualElevationMap") == std::string::npos) continue;
      const std::string ending = entry.path().extension();
      if (ending == ".bin") continue;  // the map itself, which observations2map writes from 2.14 on
      maps++;
      const auto bytes = talus::test::read_bytes(entry.path());
      EXPECT_TRUE(ending != ".tif" || bytes.substr(0, 2) == "II") << name;
      EXPECT_TRUE(ending != ".png" || bytes.substr(1, 3) == "PNG") << name;
      EXPECT_GT(bytes.size(), 2000U) << name;
    }
    EXPECT_EQ(maps, 3) << "GeoTIFF, picture and scene of one map\n" << output;
  }

  /** The GeoTIFF of the map that a program wrote with this prefix; `number` of its maps. */
  void expect_geotiff(
      const std::string& prefix, const std::string& number, int cells, double resolution_m) const
  {
    GDALAllRegister();
    const auto file = path(prefix + "_talus__CDualElevationMap_" + number + ".tif");
    GDALDataset* tif = GDALDataset::Open(file.c_str());
    ASSERT_NE(tif, nullptr) << file << "\n" << output;
    double transform[6];
    EXPECT_EQ(tif->GetRasterXSize(), cells);
    ASSERT_EQ(tif->GetGeoTransform(transform), CE_None);
    EXPECT_NEAR(transform[1], resolution_m, 1e-9);
    std::vector<float> ground(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
    int known = 0;
    for (int band = 1; band <= tif->GetRasterCount(); band++)
      if (tif->GetRasterBand(band)->GetDescription() == std::string("ground_elevation") &&
          tif->GetRasterBand(band)->RasterIO(
              GF_Read, 0, 0, cells, cells, ground.data(), cells, cells, GDT_Float32, 0, 0) ==
              CE_None)
        for (const float z : ground) known += !std::isnan(z);
    GDALClose(tif);
    EXPECT_GT(known, 100) << file;
  }

  bool says(const std::string& text) const { return output.find(text) != std::string::npos; }

  std::string output;

 private:
  talus::test::ScratchDir dir_;
};

constexpr const char* kSena = "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";
constexpr const char* kSimplemap = "localization_demo.simplemap.gz";

#define SKIP_WITHOUT(program, data) \
  if (!installed(program, data)) GTEST_SKIP() << program << " or its data are not installed"
}  // namespace

TEST_F(StockApps, icp_slam_maps_the_terrain_beside_its_points)
{
  SKIP_WITHOUT("icp-slam", kSena);
  EXPECT_EQ(run("icp-slam", kConfigs + "icp-slam.ini"), 0) << output;
  expect_terrain_map("LOG_ICP-SLAM", "_finalmaps_");
  EXPECT_TRUE(fs::exists(path("LOG_ICP-SLAM/_finalmap_.simplemap")));
  EXPECT_FALSE(says("unknown key")) << output;
}

TEST_F(StockApps, rbpf_slam_carries_the_terrain_in_every_particle)
{
  SKIP_WITHOUT("rbpf-slam", kSena);
  auto config = talus::test::read_bytes(kConfigs + "rbpf-slam.ini");
  const auto particles = config.find("sampleSize=10");
  ASSERT_NE(particles, std::string::npos);
  talus::test::write_bytes(path("few.ini"), config.replace(particles, 13, "sampleSize=3"));
  EXPECT_EQ(run("rbpf-slam", "few.ini"), 0) << output;
  expect_terrain_map("LOG_GRIDMAPPING", "finalMap_");
}

TEST_F(StockApps, pf_localization_finds_the_robot_with_the_terrain_beside_the_grid)
{
  SKIP_WITHOUT("pf-localization", kSimplemap);
  EXPECT_EQ(run("pf-localization", kConfigs + "pf-localization.ini"), 0) << output;
  const auto folder = fs::path(path("LOG_LOCALIZATION_000_0005000"));
  ASSERT_TRUE(fs::exists(folder)) << output;
  expect_terrain_map("LOG_LOCALIZATION_000_0005000", "map_");
}

TEST_F(StockApps, observations2map_honours_the_options_of_the_file)
{
  SKIP_WITHOUT("observations2map", kSimplemap);
  talus::test::write_bytes(
      path("options.ini"),
      "[MappingApplication]\nterrain_count = 1\n"
      "[MappingApplication_terrain_00_creationOpts]\nresolution = 0.2\nwindow = 12\n"
      "enableSaveAs3DObject = false\n");
  const auto map = talus::test::stock_dataset(kSimplemap);
  EXPECT_EQ(run("observations2map", "options.ini " + map + " out"), 0) << output;
  expect_geotiff("out", "00", 60, 0.2);
  EXPECT_EQ(run("observations2map", kConfigs + "observations2map.ini " + map + " shipped"), 0);
  EXPECT_FALSE(says("unknown key")) << output;
  expect_terrain_map("", "shipped");
  expect_geotiff("shipped", "01", 160, 0.1);
}

TEST_F(StockApps, observations2map_keeps_the_whole_drive_where_it_is_told_to)
{
  SKIP_WITHOUT("observations2map", kSimplemap);
  const auto map = talus::test::stock_dataset(kSimplemap);
  const auto site = [&](const std::string& prefix)
  { return path(prefix + "_talus__CDualElevationMap_00_site.tif"); };
  for (const std::string keep : {"true", "false"})
  {
    talus::test::write_bytes(
        path(keep + ".ini"),
        "[MappingApplication]\nterrain_count = 1\n"
        "[MappingApplication_terrain_00_creationOpts]\nresolution = 0.2\nwindow = 4\n"
        "keep_whole = " +
            keep + "\n");
    EXPECT_EQ(run("observations2map", keep + ".ini " + map + " " + keep), 0) << output;
    expect_geotiff(keep, "00", 20, 0.2);
  }
  EXPECT_FALSE(fs::exists(site("false")));
  GDALAllRegister();
  GDALDataset* tif = GDALDataset::Open(site("true").c_str());
  ASSERT_NE(tif, nullptr) << output;
  EXPECT_EQ(tif->GetRasterBand(2)->GetDescription(), std::string("ground_elevation"));
  std::vector<float> ground(
      static_cast<std::size_t>(tif->GetRasterXSize()) *
      static_cast<std::size_t>(tif->GetRasterYSize()));
  EXPECT_EQ(
      tif->GetRasterBand(2)->RasterIO(
          GF_Read, 0, 0, tif->GetRasterXSize(), tif->GetRasterYSize(), ground.data(),
          tif->GetRasterXSize(), tif->GetRasterYSize(), GDT_Float32, 0, 0),
      CE_None);
  GDALClose(tif);
  EXPECT_GT(
      std::count_if(ground.begin(), ground.end(), [](float z) { return !std::isnan(z); }), 4 * 400)
      << "more than four windows";
}

TEST_F(StockApps, an_observation_that_no_map_understands_is_told_once_and_left_out)
{
  SKIP_WITHOUT("observations2map", kSimplemap);
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (int x = -40; x < 40; x++)
    for (int y = -40; y < 40; y++) points->insertPoint(0.05F * x, 0.05F * y, -0.5F);
  auto cloud = mrpt::obs::CObservationPointCloud::Create();
  cloud->pointcloud = points;
  auto frame = mrpt::obs::CSensoryFrame::Create();
  frame->insert(mrpt::obs::CObservationIMU::Create());
  frame->insert(mrpt::obs::CObservationIMU::Create());
  frame->insert(cloud);
  mrpt::maps::CSimpleMap log;
  log.insert(
      std::make_shared<mrpt::poses::CPose3DPDFGaussian>(mrpt::poses::CPose3D(0, 0, 0.5, 0, 0, 0)),
      frame);
  ASSERT_TRUE(log.saveToFile(path("imu.simplemap")));
  EXPECT_EQ(run("observations2map", kConfigs + "observations2map.ini imu.simplemap out"), 0)
      << output;
  const auto first = output.find("CObservationIMU holds no points");
  EXPECT_NE(first, std::string::npos) << output;
  EXPECT_EQ(output.find("CObservationIMU holds no points", first + 1), std::string::npos) << output;
  expect_geotiff("out", "01", 160, 0.1);
}

TEST_F(StockApps, observations2map_is_told_about_a_map_that_is_asked_for_under_two_names)
{
  SKIP_WITHOUT("observations2map", kSimplemap);
  talus::test::write_bytes(
      path("twice.ini"),
      "[MappingApplication]\nterrain_count = 1\ntalus::CDualElevationMap_count = 1\n");
  const auto map = talus::test::stock_dataset(kSimplemap);
  EXPECT_EQ(run("observations2map", "twice.ini " + map + " out"), 0) << output;
  EXPECT_TRUE(says("leave one of them")) << output;
}

TEST_F(StockApps, two_copies_of_the_plugin_make_one_map_and_say_which_counts)
{
  SKIP_WITHOUT("observations2map", kSimplemap);
  const auto arguments =
      kConfigs + "observations2map.ini " + talus::test::stock_dataset(kSimplemap) + " out";
  EXPECT_EQ(run("observations2map", arguments, 2), 0) << output;
  EXPECT_TRUE(says("that copy stays")) << output;
  expect_terrain_map("", "out");
}
