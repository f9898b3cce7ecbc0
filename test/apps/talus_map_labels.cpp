// talus-map --labels: what each point of a log is, as files and as a log of clouds.
#include "talus_map_run.h"

#include <talus/io/rawlog_reader.h>
#include <talus/mrpt/version_compat.h>

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace talus;
using namespace talus::test;

namespace
{

class TalusMapLabels : public TalusMap
{
 protected:
  /** The numbers of one file. */
  std::vector<std::uint32_t> labels_in(const std::string& name) const
  {
    const std::string bytes = read_bytes(path(name));
    std::vector<std::uint32_t> labels(bytes.size() / 4);
    if (!labels.empty()) std::memcpy(labels.data(), bytes.data(), 4 * labels.size());
    return labels;
  }
  /** Each label of a file, run by run: 3721 of the ground is "1 x 3721". */
  std::string runs_in(const std::string& name) const
  {
    const auto labels = labels_in(name);
    std::string text;
    for (auto i = labels.begin(), end = i; i != labels.end(); i = end)
    {
      end = std::find_if(i, labels.end(), [&](std::uint32_t l) { return l != *i; });
      text += (text.empty() ? "" : ", ") + std::to_string(*i) + " x " + std::to_string(end - i);
    }
    return text;
  }
};

/** The floor, then a wall 0.2 to 0.4 m up, then one point each: none, too far, outside. */
std::shared_ptr<mrpt::obs::CObservationPointCloud> scan_of_all_kinds(double time_s)
{
  auto obs = floor_scan(time_s);
  auto& points = *obs->pointcloud;
  const auto height = static_cast<float>(kSensorHeight_m);
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 5; ++j)
      points.insertPoint(
          1.52F, 0.1F * static_cast<float>(i - 15) + 0.02F,
          0.2F + 0.05F * static_cast<float>(j) - height);
  points.insertPoint(std::nanf(""), 0, 0);
  points.insertPoint(500, 0, 0);
  points.insertPoint(10, 0, -height);
  return obs;
}
const std::string kAllKinds = "1 x 3721, 2 x 150, 0 x 2, 6 x 1";
}  // namespace

TEST_F(TalusMapLabels, writes_a_number_for_each_point_in_the_order_of_the_scan)
{
  write_log(
      path("drive.rawlog"),
      {scan_of_all_kinds(kFirstStamp_s), floor_scan(kFirstStamp_s + 0.1),
       scan_of_all_kinds(kFirstStamp_s + 0.2)},
      Packing::Gz);
  const CommandEnd done = runs("drive.rawlog --static --labels labels");
  EXPECT_EQ(runs_in("labels/000000.label"), kAllKinds);
  EXPECT_EQ(runs_in("labels/000001.label"), "1 x 3721");
  EXPECT_EQ(runs_in("labels/000002.label"), kAllKinds);
  const std::string table = read_bytes(path("labels/labels.yaml"));
  for (const char* row : {"0: \"not_taken\"", "1: \"ground\"", "6: \"outside\"", "color_map:"})
    EXPECT_SAYS(table, row) << " not in ";
  EXPECT_SAYS(done.out, "labels");
  EXPECT_TRUE(exists("drive_map/summary.json"));
}

TEST_F(TalusMapLabels, of_scans_that_were_not_mapped_are_zeros)
{
  Objects objects = floor_scans(4);
  objects.push_back(std::make_shared<mrpt::obs::CObservationIMU>());
  objects.push_back(floor_scan(kFirstStamp_s + 0.4));
  write_log(path("drive.rawlog"), objects, Packing::Gz);
  write_bytes(path("drive.tum"), straight_tum(3));
  runs("drive.rawlog --labels labels --max-gap 0.15");
  EXPECT_EQ(summary("drive_map")["frames"], 3);
  EXPECT_EQ(runs_in("labels/000002.label"), "1 x 3721");
  EXPECT_EQ(runs_in("labels/000003.label"), "0 x 3721");
  EXPECT_EQ(runs_in("labels/000004.label"), "0 x 3721");
  EXPECT_FALSE(exists("labels/000005.label")) << "what holds no points is no scan";
}

TEST_F(TalusMapLabels, of_parts_of_a_scan_go_to_the_parts)
{
  Objects parts;
  for (int i = 0; i < 25; ++i)
    parts.push_back(
        i % 2 ? floor_scan(kFirstStamp_s + 0.01 * i) : scan_of_all_kinds(kFirstStamp_s + 0.01 * i));
  write_log(path("drive.rawlog"), parts, Packing::Gz);
  runs("drive.rawlog --static --labels labels");
  EXPECT_EQ(summary("drive_map")["frames"], 4);
  for (int i = 0; i < 25; ++i)
  {
    const std::string file = "labels/0000" + std::string(i < 10 ? "0" : "") + std::to_string(i);
    EXPECT_EQ(runs_in(file + ".label"), i % 2 ? "1 x 3721" : kAllKinds) << file;
  }
}

TEST_F(TalusMapLabels, can_be_a_log_of_clouds)
{
  const Objects scans{
      scan_of_all_kinds(kFirstStamp_s), floor_scan(kFirstStamp_s + 0.1, "rear"),
      scan_of_all_kinds(kFirstStamp_s + 0.2)};
  write_log(path("drive.rawlog"), scans, Packing::Gz);
  runs("drive.rawlog --static --labels files");
  runs("drive.rawlog --static --labels clouds --labels-as rawlog");
  EXPECT_FALSE(exists("clouds/000000.label"));
  EXPECT_TRUE(exists("clouds/labels.yaml"));
  io::RawlogReader reader(path("clouds/labels.rawlog"));
  for (std::size_t s = 0; s < scans.size(); ++s)
  {
    const auto obs = std::dynamic_pointer_cast<mrpt::obs::CObservationPointCloud>(reader.next());
    ASSERT_TRUE(obs) << "scan " << s;
    const auto& scan = dynamic_cast<const mrpt::obs::CObservationPointCloud&>(*scans[s]);
    EXPECT_EQ(obs->timestamp, scan.timestamp);
    EXPECT_EQ(obs->sensorLabel, scan.sensorLabel);
    EXPECT_EQ(obs->sensorPose, scan.sensorPose);
    const auto labels = labels_in("files/00000" + std::to_string(s) + ".label");
    ASSERT_EQ(obs->pointcloud->size(), scan.pointcloud->size());
    ASSERT_EQ(labels.size(), scan.pointcloud->size());
    const auto& cloud = dynamic_cast<const talus::detail::CloudWithIntensity&>(*obs->pointcloud);
    for (std::size_t i = 0; i < labels.size(); ++i)
    {
      ASSERT_EQ(talus::detail::intensity_of(cloud, i), static_cast<float>(labels[i]))
          << "point " << i;
      float a[3], b[3];
      cloud.getPoint(i, a[0], a[1], a[2]);
      scan.pointcloud->getPoint(i, b[0], b[1], b[2]);
      ASSERT_EQ(std::memcmp(a, b, sizeof a), 0) << "point " << i;
    }
  }
  EXPECT_FALSE(reader.next());
}

TEST_F(TalusMapLabels, of_an_import_say_where_they_are_fewer_than_the_points_of_a_file)
{
  std::vector<float> values;
  for (int i = 0; i < 300; ++i)
    for (const float v : {0.01F * static_cast<float>(i) + 1, 0.5F, -0.5F, 0.0F})
      values.push_back(v);
  values[4 * 7] = std::nanf("");
  std::string bytes(4 * values.size(), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  std::filesystem::create_directories(path("front"));
  write_bytes(path("front/scan.bin"), bytes);
  const CommandEnd done = runs("front/scan.bin --mount front=0,0,0.5,0,0,0 --labels labels");
  EXPECT_TRUE(done.says("the import left out 1 point that is not finite")) << done.err;
  EXPECT_EQ(labels_in("labels/000000.label").size(), 299U);
}

TEST_F(TalusMapLabels, of_a_batch_have_a_folder_for_each_log)
{
  write_log(path("a.rawlog"), floor_scans(1), Packing::Gz);
  write_log(path("b.rawlog"), floor_scans(2), Packing::Gz);
  runs("a.rawlog b.rawlog --static --output maps --labels labels --jobs 2");
  EXPECT_TRUE(exists("labels/a/000000.label"));
  EXPECT_TRUE(exists("labels/b/000001.label"));
  EXPECT_TRUE(exists("labels/b/labels.yaml"));
}

TEST_F(TalusMapLabels, are_refused_where_they_would_replace_those_of_people)
{
  write_log(path("drive.rawlog"), floor_scans(1), Packing::Gz);
  std::filesystem::create_directories(path("sequence/labels"));
  write_bytes(path("sequence/labels/000000.label"), "made by hand");
  fails(
      "drive.rawlog --static --labels sequence/labels", 1,
      {"--labels sequence/labels: has labels that talus-map did not write"});
  EXPECT_EQ(read_bytes(path("sequence/labels/000000.label")), "made by hand");
  EXPECT_FALSE(exists("drive_map"));
}

TEST_F(TalusMapLabels, name_the_option_where_nothing_can_be_written)
{
  write_log(path("drive.rawlog"), floor_scans(1), Packing::Gz);
  write_bytes(path("taken"), "a file");
  fails(
      "drive.rawlog --static --labels taken", 1,
      {"this is not a folder; give a folder that you may write to with --labels"});
  std::filesystem::create_directories(path("l"));
  std::filesystem::rename(path("drive.rawlog"), path("l/labels.rawlog"));
  fails(
      "l/labels.rawlog --static --labels l --labels-as rawlog", 1,
      {"'l/labels.rawlog' would be overwritten, but it is an input"});
}

TEST_F(TalusMapLabels, options_that_do_nothing_are_wrong_usage)
{
  write_log(path("drive.rawlog"), floor_scans(1), Packing::Gz);
  fails("drive.rawlog --static --labels-as rawlog", 2, {});
  fails("drive.rawlog --static --labels l --labels-as pcd", 2, {});
  fails("drive.rawlog --static --labels l --suggest", 2, {});
  fails("drive.rawlog --static --labels ''", 2, {});
  EXPECT_FALSE(exists("l"));
}
