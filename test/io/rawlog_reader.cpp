#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/io/lazy_load_path.h>
#include <sys/stat.h>
#include <talus/io/rawlog_reader.h>

#include <cmath>

#include "log_files.h"

using namespace mrpt::obs;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;
using talus::io::RawlogReader;
using talus::io::trajectory_from_rawlog;
using namespace talus::test;

namespace
{
std::vector<CObservation::Ptr> read_all(const std::string& path)
{
  RawlogReader reader(path);
  std::vector<CObservation::Ptr> all;
  while (auto obs = reader.next()) all.push_back(obs);
  return all;
}

CObservationOdometry::Ptr odometry(double time_s, double x_m, const std::string& label = "odom")
{
  auto obs = observation_at<CObservationOdometry>(time_s, label);
  obs->odometry = CPose2D(x_m, 0, 0);
  return obs;
}

CObservationPointCloud::Ptr cloud(double time_s, std::size_t points)
{
  auto obs = observation_at<CObservationPointCloud>(time_s, "lidar");
  auto map = mrpt::maps::CSimplePointsMap::Create();
  for (std::size_t i = 0; i < points; ++i) map->insertPoint(static_cast<float>(i), 0.5f, -0.5f);
  obs->pointcloud = map;
  return obs;
}

/** A robot that moves 1 m forward and turns left by 90 degrees. */
CActionCollection::Ptr step_and_turn()
{
  CActionRobotMovement2D movement;
  movement.computeFromOdometry(CPose2D(1, 0, M_PI / 2), {});
  auto actions = std::make_shared<CActionCollection>();
  actions->insert(movement);
  return actions;
}

CSensoryFrame::Ptr frame_of(const std::vector<CObservation::Ptr>& observations)
{
  auto frame = std::make_shared<CSensoryFrame>();
  for (const auto& obs : observations) frame->insert(obs);
  return frame;
}

const Objects kThree{odometry(1, 1), odometry(2, 2), odometry(3, 3)};

}  // namespace

TEST(RawlogReader, FlattensSensoryFramesAlsoThoseWithoutAnActionBefore)
{
  const ScratchDir dir;
  write_log(
      dir / "a.rawlog",
      {frame_of({odometry(1, 1), cloud(1, 5)}), frame_of({}), step_and_turn(),
       frame_of({cloud(2, 6)})},
      Packing::Gz);
  const auto all = read_all(dir / "a.rawlog");
  ASSERT_EQ(all.size(), 3u);
  EXPECT_TRUE(std::dynamic_pointer_cast<CObservationOdometry>(all[0]));
  EXPECT_EQ(std::dynamic_pointer_cast<CObservationPointCloud>(all[1])->pointcloud->size(), 5u);
  EXPECT_EQ(std::dynamic_pointer_cast<CObservationPointCloud>(all[2])->pointcloud->size(), 6u);
}

TEST(RawlogReader, ReadsWhatMrptsOwnContainerWrites)
{
  const ScratchDir dir;
  CRawlog log;
  log.setCommentText("a comment is not an observation");
  log.insert(std::static_pointer_cast<CObservation>(odometry(1, 1)));
  log.insert(std::static_pointer_cast<CObservation>(odometry(2, 2)));
  ASSERT_TRUE(log.saveToRawLogFile(dir / "a.rawlog"));
  EXPECT_EQ(read_all(dir / "a.rawlog").size(), 2u);
  EXPECT_EQ(RawlogReader(dir / "a.rawlog").description(), "a comment is not an observation");
}

namespace
{
/** A log whose points lie in files of the directory beside it. */
void write_external_log(const ScratchDir& dir)
{
  std::filesystem::create_directories(dir / "a_Images");
  mrpt::io::setLazyLoadPathBase(dir / "a_Images");
  const auto points = cloud(1, 7);
  points->setAsExternalStorage(
      "points.bin", CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
  points->unload();

  const auto depth = observation_at<CObservation3DRangeScan>(2, "depth");
  depth->hasRangeImage = true;
  depth->rangeImage_setSize(2, 3);
  depth->rangeImage.fill(1500);
  depth->rangeImage_convertToExternalStorage("depth.bin", dir / "a_Images/");
  write_log(dir / "a.rawlog", {points, depth}, Packing::Gz);
  mrpt::io::setLazyLoadPathBase(".");
}
}  // namespace

TEST(RawlogReader, LoadsPointsAndDepthImagesThatAreStoredOutsideTheLog)
{
  const ScratchDir dir;
  write_external_log(dir);
  const auto all = read_all(dir / "a.rawlog");
  ASSERT_EQ(all.size(), 2u);
  const auto points = std::dynamic_pointer_cast<CObservationPointCloud>(all[0])->pointcloud;
  ASSERT_TRUE(points);
  EXPECT_EQ(points->size(), 7u);
  const auto depth = std::dynamic_pointer_cast<CObservation3DRangeScan>(all[1]);
  ASSERT_EQ(depth->rangeImage.rows(), 2);
  EXPECT_EQ(depth->rangeImage(1, 2), 1500);
}

TEST(RawlogReader, NamesTheDirectoryWhenOutsideDataIsMissing)
{
  const ScratchDir dir;
  write_external_log(dir);
  std::filesystem::remove_all(dir / "a_Images");
  expect_error(
      [&] { read_all(dir / "a.rawlog"); },
      {"a.rawlog", "byte 0", "'lidar'", "external data", "a_Images"});
}

TEST(RawlogReader, DoesNotWaitForAPipeInThePlaceOfOutsideData)
{
  for (const std::string name : {"points.bin", "depth.bin"})
  {
    const ScratchDir dir;
    write_external_log(dir);
    std::filesystem::remove(dir / "a_Images/" + name);
    ASSERT_EQ(::mkfifo((dir / "a_Images/" + name).c_str(), 0600), 0);
    expect_error(
        [&] { read_all(dir / "a.rawlog"); }, {"a.rawlog", "external data", name + ": is a pipe"});
  }
}

TEST(RawlogReader, DoesNotNeedPicturesThatAreStoredOutsideTheLog)
{
  const ScratchDir dir;
  const auto picture = observation_at<CObservationImage>(1, "camera");
  picture->image.setExternalStorage("missing.png");
  write_log(dir / "a.rawlog", {picture, odometry(2, 2)}, Packing::Gz);
  EXPECT_EQ(read_all(dir / "a.rawlog").size(), 2u);
}

TEST(RawlogReader, SaysWhenTheFileIsMissingADirectoryEmptyOrText)
{
  const ScratchDir dir;
  expect_error([&] { RawlogReader(dir / "none.rawlog"); }, {"none.rawlog", "no such file"});
  expect_error([&] { RawlogReader(dir / ""); }, {"is a directory", "rawlog"});
  write_bytes(dir / "empty.rawlog", "");
  expect_error([&] { RawlogReader(dir / "empty.rawlog"); }, {"empty.rawlog", "0 bytes"});
  write_log(dir / "nothing.rawlog", {}, Packing::Gz);
  expect_error([&] { RawlogReader(dir / "nothing.rawlog"); }, {"nothing.rawlog"});
  write_bytes(dir / "notes.rawlog", "These are notes of the test drive,\nnot its log.\n");
  expect_error([&] { RawlogReader(dir / "notes.rawlog"); }, {"notes.rawlog", "not a rawlog"});
}

TEST(RawlogReader, NamesTheByteWhereAPlainLogIsCutAndGivesWhatIsBefore)
{
  const ScratchDir dir;
  write_log(dir / "one.rawlog", {kThree[0]}, Packing::Plain);
  write_log(dir / "a.rawlog", kThree, Packing::Plain);
  const auto one = read_bytes(dir / "one.rawlog").size();
  const auto bytes = read_bytes(dir / "a.rawlog");
  for (const std::size_t missing : {std::size_t(1), std::size_t(20), one - 1})
  {
    write_bytes(dir / "cut.rawlog", bytes.substr(0, bytes.size() - missing));
    RawlogReader reader(dir / "cut.rawlog");
    EXPECT_TRUE(reader.next());
    EXPECT_TRUE(reader.next());
    expect_error(
        [&] { reader.next(); }, {"cut.rawlog", "byte " + std::to_string(2 * one), "cut short",
                                 "at byte " + std::to_string(bytes.size() - missing)});
  }
}

TEST(RawlogReader, NamesTheByteWhereALogIsDamaged)
{
  const ScratchDir dir;
  write_log(dir / "one.rawlog", {kThree[0]}, Packing::Plain);
  const auto one = read_bytes(dir / "one.rawlog").size();
  for (const auto packing : {Packing::Plain, Packing::Gz})
  {
    write_log(dir / "a.rawlog", kThree, Packing::Plain);
    auto bytes = read_bytes(dir / "a.rawlog");
    bytes[one] = 0;  // the length of the class name of the second object
    write_bytes(dir / "bad.rawlog", bytes);
    if (packing == Packing::Gz)
    {
      mrpt::io::CFileGZOutputStream gz(dir / "bad.rawlog");
      gz.Write(bytes.data(), bytes.size());
    }
    RawlogReader reader(dir / "bad.rawlog");
    EXPECT_TRUE(reader.next());
    expect_error(
        [&] { reader.next(); }, {"bad.rawlog", "byte " + std::to_string(one), "cannot be read"});
  }
}

TEST(RawlogReader, NamesTheByteOfAFrameThatLacksAnObservation)
{
  const ScratchDir dir;
  write_log(dir / "a.rawlog", {frame_of({})}, Packing::Plain);
  auto bytes = read_bytes(dir / "a.rawlog");
  const std::string name = "CSensoryFrame", null = "\x87nullptr\x88";
  const auto size_at = bytes.find(name) + name.size() + 1;  // behind its version
  ASSERT_EQ(bytes.substr(size_at), std::string(4, '\0') + "\x88");
  bytes[size_at] = 1;
  bytes.insert(size_at + 4, null);
  write_bytes(dir / "bad.rawlog", bytes);
  const std::vector<std::string> words{"bad.rawlog", "byte 0", "null object", "damaged"};
  expect_error([&] { read_all(dir / "bad.rawlog"); }, words);
  expect_error([&] { trajectory_from_rawlog(dir / "bad.rawlog"); }, words);
}

TEST(RawlogReader, NamesTheClassThatItDoesNotKnow)
{
  const ScratchDir dir;
  write_log(dir / "a.rawlog", kThree, Packing::Plain);
  auto bytes = read_bytes(dir / "a.rawlog");
  const std::string known = "CObservationOdometry";
  bytes.replace(bytes.rfind(known), known.size(), "CObservationOfAnimal");
  write_bytes(dir / "bad.rawlog", bytes);
  RawlogReader reader(dir / "bad.rawlog");
  EXPECT_TRUE(reader.next());
  EXPECT_TRUE(reader.next());
  expect_error([&] { reader.next(); }, {"CObservationOfAnimal", "plugin"});
}

TEST(RawlogReader, SaysThatANewerMrptWroteWhatItCannotRead)
{
  const ScratchDir dir;
  write_log(dir / "a.rawlog", {kThree[0]}, Packing::Plain);
  auto bytes = read_bytes(dir / "a.rawlog");
  const std::string name = "CObservationOdometry";
  bytes[bytes.find(name) + name.size()] = 99;  // the version of what follows
  write_bytes(dir / "new.rawlog", bytes);
  expect_error(
      [&] { RawlogReader{dir / "new.rawlog"}; }, {"new.rawlog", "byte 0", "newer MRPT", "99"});
}

TEST(RawlogReader, ReadsTheLogsThatComeWithMrpt)
{
  const auto scan = stock_dataset("test_velodyne_VLP16.rawlog");
  const auto actions = stock_dataset("localization_demo.rawlog");
  const auto plain = stock_dataset("RO-SLAM_demo.rawlog");
  if (scan.empty() || actions.empty() || plain.empty()) GTEST_SKIP() << "mrpt-common is not here";
  EXPECT_EQ(read_all(scan).size(), 1u);
  EXPECT_EQ(read_all(actions).size(), 37u);
  EXPECT_GT(trajectory_from_rawlog(actions).entries().size(), 1u);
  EXPECT_EQ(read_all(plain).size(), 100u);
}

TEST(PosesOfALog, ComeFromRobotPosesFirst)
{
  const ScratchDir dir;
  const auto pose = observation_at<CObservationRobotPose>(1, "gps");
  pose->pose.mean = CPose3D(10, 0, 0, M_PI / 2, 0, 0);
  pose->sensorPose = CPose3D(2, 0, 0, 0, 0, 0);  // the antenna is 2 m ahead of the base
  write_log(dir / "a.rawlog", {odometry(1, 1), pose, odometry(2, 2)}, Packing::Gz);
  std::string source;
  const auto t = trajectory_from_rawlog(dir / "a.rawlog", &source);
  EXPECT_EQ(source, "CObservationRobotPose 'gps'");
  ASSERT_EQ(t.entries().size(), 1u);
  EXPECT_NEAR(t.entries()[0].T_map_base.x(), 10, 1e-12);
  EXPECT_NEAR(t.entries()[0].T_map_base.y(), -2, 1e-12);
}

TEST(PosesOfALog, ComeFromOneOdometryOnlyTheOneWithTheMostPoses)
{
  const ScratchDir dir;
  write_log(
      dir / "a.rawlog",
      {odometry(1, 100, "visual"), odometry(1, 1, "wheels"), odometry(2, 2, "wheels")},
      Packing::Gz);
  std::string source;
  const auto t = trajectory_from_rawlog(dir / "a.rawlog", &source);
  EXPECT_EQ(source, "CObservationOdometry 'wheels'");
  EXPECT_DOUBLE_EQ(t.at(1.5, 1)->x(), 1.5);
}

TEST(PosesOfALog, AreTheFiniteOnes)
{
  const ScratchDir dir;
  const auto lost = observation_at<CObservationRobotPose>(1, "gps");
  lost->pose.mean = CPose3D(std::nan(""), 0, 0, 0, 0, 0);
  write_log(
      dir / "a.rawlog", {odometry(1, 1), odometry(1.5, std::nan("")), odometry(2, 2), lost},
      Packing::Gz);
  std::string source;
  const auto t = trajectory_from_rawlog(dir / "a.rawlog", &source);
  EXPECT_EQ(source, "CObservationOdometry 'odom'") << "a source without poses is none";
  ASSERT_EQ(t.entries().size(), 2u);
  EXPECT_DOUBLE_EQ(t.at(1.5, 1)->x(), 1.5);
}

TEST(PosesOfALog, AreTheSumOfItsMovementsWhenItHasActionPairs)
{
  const ScratchDir dir;
  write_log(
      dir / "a.rawlog",
      {frame_of({cloud(10, 1)}), step_and_turn(), frame_of({cloud(11, 1), cloud(11.25, 1)}),
       step_and_turn(), frame_of({cloud(12, 1)})},
      Packing::Gz);
  std::string source;
  const auto t = trajectory_from_rawlog(dir / "a.rawlog", &source);
  EXPECT_SAYS(source, "action");
  ASSERT_EQ(t.entries().size(), 4u);
  EXPECT_NEAR(t.at(10, 2)->norm(), 0, 1e-12);
  EXPECT_NEAR(t.at(11.25, 2)->x(), 1, 1e-12);
  EXPECT_NEAR(t.at(11.25, 2)->yaw(), M_PI / 2, 1e-12);
  EXPECT_NEAR(t.at(12, 2)->x(), 1, 1e-12);
  EXPECT_NEAR(t.at(12, 2)->y(), 1, 1e-12);
}
