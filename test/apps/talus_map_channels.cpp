// talus-map --channels: values that points bring, as bands and panels of the map.
#include "scan_formats.h"
#include "talus_map_run.h"

#include <talus/io/geotiff.h>
#include <talus/mrpt/version_compat.h>

#include <cmath>

using namespace talus;
using namespace talus::test;

namespace
{
using TalusMapChannels = TalusMap;

/** The floor with a box on it; the intensity of a point says which, and where. */
std::shared_ptr<mrpt::obs::CObservationPointCloud> valued_scan(double time_s)
{
  auto obs = floor_scan(time_s);
  auto& floor = *obs->pointcloud;
  const auto height = static_cast<float>(kSensorHeight_m);
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j)
      floor.insertPoint(
          1.02F + 0.05F * static_cast<float>(i), 0.02F + 0.05F * static_cast<float>(j),
          0.4F - height);
  const auto cloud = talus::detail::make_cloud_with_intensity(floor.size());
  for (std::size_t i = 0; i < floor.size(); ++i)
  {
    float x = 0, y = 0, z = 0;
    floor.getPoint(i, x, y, z);
    cloud->setPointFast(i, x, y, z);
    talus::detail::set_intensity(*cloud, i, z > 0.3F - height ? 9.0F : x < 0 ? 3.0F : 5.0F);
  }
  obs->pointcloud = cloud;
  return obs;
}

Objects valued_scans(int frames)
{
  Objects scans;
  for (int i = 0; i < frames; ++i) scans.push_back(valued_scan(kFirstStamp_s + 0.1 * i));
  return scans;
}

/** How many cells of a band have each value. */
std::map<float, int> counts_of(const io::LayerStack& map, const std::string& band)
{
  std::map<float, int> counts;
  const auto* values = map.find(band);
  EXPECT_TRUE(values) << band;
  if (values)
    for (const float v : *values)
      if (!std::isnan(v)) ++counts[v];
  return counts;
}
}  // namespace

TEST_F(TalusMapChannels, become_bands_of_the_map_and_panels_of_its_picture)
{
  write_log(path("drive.rawlog"), valued_scans(3), Packing::Gz);
  for (const std::string rule : {"mean", "vote"})
  {
    runs("drive.rawlog --static --channels intensity:" + rule + " --output " + rule);
    const auto map = io::read_geotiff(path(rule + "/map.tif"));
    const auto ground = counts_of(map, "intensity"), top = counts_of(map, "intensity_standing");
    EXPECT_GT(ground.at(3), 1000);
    EXPECT_GT(ground.at(5), 1000);
    EXPECT_EQ(ground.count(9), 0U);
    ASSERT_EQ(top.size(), 1U);
    EXPECT_GE(top.at(9), 380);
    EXPECT_EQ(summary(rule)["parameters"]["channels"], "intensity:" + rule);
  }
  runs("drive.rawlog --static --output plain");
  EXPECT_EQ(summary("plain")["parameters"]["channels"], "none");
  EXPECT_EQ(io::read_geotiff(path("plain/map.tif")).find("intensity"), nullptr);
  EXPECT_EQ(io::read_geotiff(path("plain/site.tif")).find("intensity"), nullptr);
  EXPECT_GT(read_bytes(path("mean/map.png")).size(), read_bytes(path("plain/map.png")).size());
}

TEST_F(TalusMapChannels, whose_classes_cost_make_cells_impassable)
{
  write_log(path("drive.rawlog"), valued_scans(3), Packing::Gz);
  write_bytes(
      path("costs.ini"),
      "[CDualElevationMap_insertOpts]\nchannels = intensity:vote\nchannel_cost = "
      "intensity:3=0,5=0.5\n");
  runs("drive.rawlog --static --config costs.ini --output file");
  runs(
      "drive.rawlog --static --channels intensity:vote -s channel_cost=intensity:3=0,5=0.5 "
      "--output cost");
  EXPECT_EQ(read_bytes(path("file/map.tif")), read_bytes(path("cost/map.tif")));
  const auto scores = counts_of(io::read_geotiff(path("cost/map.tif")), "traversability");
  EXPECT_GT(scores.at(0), 1000);
  EXPECT_GT(scores.at(0.5F), 1000);
  EXPECT_EQ(summary("cost")["parameters"]["channel_cost"], "intensity:3=0,intensity:5=0.5");
}

/** A resumed map keeps channels that are not asked for again, and takes more. */
TEST_F(TalusMapChannels, become_bands_of_the_site_that_last)
{
  for (const std::string log : {"monday", "tuesday", "wednesday"})
  {
    write_log(path(log + ".rawlog"), valued_scans(3), Packing::Gz);
    write_bytes(path(log + ".tum"), straight_tum(3));
  }
  runs("monday.rawlog --channels intensity:vote");
  const auto monday = io::read_geotiff(path("monday_map/site.tif"));
  EXPECT_GT(counts_of(monday, "intensity").at(5), 1000);
  EXPECT_GE(counts_of(monday, "intensity_standing").at(9), 380);
  runs("tuesday.rawlog --resume monday_map/site.tif");
  const auto tuesday = io::read_geotiff(path("tuesday_map/site.tif"));
  EXPECT_EQ(counts_of(tuesday, "intensity").at(5), counts_of(monday, "intensity").at(5));
  fails(
      "wednesday.rawlog --resume monday_map/site.tif --channels intensity:mean", 1,
      {"monday_map/site.tif: its channels"});
}

namespace
{
/** Two scans of the floor as KITTI keeps them, with labels: 40 ahead, 48 behind, 5 to the left. */
struct LabelledScans : TalusMap
{
  void write_scans() const
  {
    for (const char* folder : {"d/velodyne", "d/labels"})
      std::filesystem::create_directories(path(folder));
    std::string points, labels;
    for (int i = -30; i <= 30; ++i)
      for (int j = -30; j <= 30; ++j)
      {
        const float x_m = 0.1F * static_cast<float>(i) + 0.02F,
                    y_m = 0.1F * static_cast<float>(j) + 0.02F;
        for (const float v : {x_m, y_m, -static_cast<float>(kSensorHeight_m), 0.25F})
          put(points, v);
        put(labels, y_m > 1 ? std::uint32_t{5} : x_m > 0 ? std::uint32_t{40} : std::uint32_t{48});
      }
    for (const char* name : {"000000", "000001"})
    {
      write_bytes(path(std::string("d/velodyne/") + name + ".bin"), points);
      write_bytes(path(std::string("d/labels/") + name + ".label"), labels);
    }
    write_bytes(path("way.tum"), "0 0 0 0 0 0 0 1\n10 0 0 0 0 0 0 1\n");
  }
  const std::string import_ = "d --poses way.tum --mount velodyne=0,0,0.5,0,0,0 ";
};
}  // namespace

TEST_F(LabelledScans, of_semantickitti_become_classes_of_the_map)
{
  write_scans();
  runs(import_ + "--channels semantickitti:vote --keep-log --output out");
  const auto ground = counts_of(io::read_geotiff(path("out/site.tif")), "semantickitti");
  EXPECT_GT(ground.at(6), 500);
  EXPECT_GT(ground.at(8), 500);
  EXPECT_GT(ground.at(0), 500) << "5 is none of its labels";
  EXPECT_EQ(ground.size(), 3U);
  // The log says what its intensities are.
  const CommandEnd again =
      runs("out/d.rawlog --trajectory way.tum --channels semantickitti:vote --output again");
  EXPECT_EQ(counts_of(io::read_geotiff(path("again/site.tif")), "semantickitti"), ground);
  fails("out/d.rawlog --trajectory way.tum --channels intensity:mean", 1, {"'intensity'"});
}

TEST_F(LabelledScans, that_are_no_classes_or_of_two_kinds_are_refused)
{
  write_scans();
  fails(import_ + "--channels label:vote", 1, {"has the value 48, which is no class"});
  fails(import_ + "--channels label:max,intensity:mean", 1, {"one value of each point"});
  runs(import_ + "--channels label:max --output out");
  EXPECT_EQ(counts_of(io::read_geotiff(path("out/site.tif")), "label").count(40), 1U);
}

#if MRPT_VERSION < 0x030000
TEST_F(TalusMapChannels, rgb_stands_for_the_three_colours)
{
  auto obs = floor_scan(kFirstStamp_s);
  auto cloud = mrpt::maps::CColouredPointsMap::Create();
  cloud->resize(obs->pointcloud->size());
  for (std::size_t i = 0; i < cloud->size(); ++i)
  {
    float x = 0, y = 0, z = 0;
    obs->pointcloud->getPoint(i, x, y, z);
    cloud->setPointFast(i, x, y, z);
    cloud->setPointColor(i, 1, 0, 1);
  }
  obs->pointcloud = cloud;
  write_log(path("drive.rawlog"), {obs}, Packing::Gz);
  runs("drive.rawlog --static --channels rgb:mean --output out");
  const auto map = io::read_geotiff(path("out/map.tif"));
  for (const auto& [band, value] :
       {std::pair{"red", 255.0F}, std::pair{"green", 0.0F}, std::pair{"blue", 255.0F}})
  {
    const auto counts = counts_of(map, band);
    ASSERT_EQ(counts.size(), 1U) << band;
    EXPECT_EQ(counts.begin()->first, value);
  }
}
#endif

TEST_F(TalusMapChannels, that_the_log_does_not_have_are_named)
{
  write_log(path("drive.rawlog"), valued_scans(2), Packing::Gz);
  fails(
      "drive.rawlog --static --channels intensity:mean,label:vote", 1,
      {"no scan of it has the values 'label'"});
  EXPECT_FALSE(exists("drive_map"));
}

TEST_F(TalusMapChannels, or_costs_that_are_none_are_wrong_usage)
{
  const std::string costs = "intensity:vote -s channel_cost=";
  for (const auto& [text, word] : std::map<std::string, std::string>{
           {"intensity", "has no rule"},
           {"rgb:mean,intensity:mean,label:vote", "5 of them"},
           {costs + "label:3=0", "no channel 'label'"},
           {costs + "intensity:16=0", "a class is"}})
  {
    fails("drive.rawlog --static --channels " + text, 2, {word});
  }
}
