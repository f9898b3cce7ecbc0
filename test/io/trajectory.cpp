#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <talus/io/trajectory.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>

#include "log_files.h"

using mrpt::poses::CPose3D;
using talus::io::Trajectory;
using namespace talus::test;

namespace
{
constexpr double kDegree = M_PI / 180;

CPose3D pose(double x, double y = 0, double z = 0, double yaw_deg = 0)
{
  return CPose3D(x, y, z, yaw_deg * kDegree, 0, 0);
}

/** Loads a TUM file with that text. */
Trajectory load_text(const ScratchDir& dir, const std::string& text)
{
  write_bytes(dir / "poses.tum", text);
  return Trajectory::load(dir / "poses.tum");
}

}  // namespace

TEST(Trajectory, SortsItsEntriesByTime)
{
  const Trajectory t({{3, pose(30)}, {1, pose(10)}, {2, pose(20)}});
  ASSERT_EQ(t.entries().size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(t.entries()[static_cast<size_t>(i)].time_s, i + 1);
  EXPECT_DOUBLE_EQ(t.at(1.5, 10)->x(), 15);
}

TEST(Trajectory, KeepsTheLastOfEntriesWithTheSameTime)
{
  const Trajectory t({{1, pose(1)}, {2, pose(2)}, {1, pose(3)}, {2, pose(4)}, {1, pose(5)}});
  ASSERT_EQ(t.entries().size(), 2u);
  EXPECT_EQ(t.entries()[0].T_map_base.x(), 5);
  EXPECT_EQ(t.entries()[1].T_map_base.x(), 4);
}

TEST(Trajectory, IsWrittenToTheLastBit)
{
  for (int i = 0; i < 1000; ++i)
  {
    const CPose3D any(i / 7.0, -i / 3.0, i / 11.0, 0.37 * i, 0.3 * std::sin(i), 0.3 * std::cos(i));
    const auto read = talus::io::as_in_tum({i / 10.0, any});
    const auto again = talus::io::as_in_tum(read).T_map_base;
    EXPECT_TRUE(again.getRotationMatrix() == read.T_map_base.getRotationMatrix()) << i;
  }
}

TEST(Trajectory, InterpolatesPositionLinearlyAndRotationOnTheSphere)
{
  const Trajectory t({{10, pose(0, 0, 1, 0)}, {12, pose(4, -2, 2, 90)}});
  const auto p = t.at(10.5, 5);
  ASSERT_TRUE(p);
  EXPECT_NEAR(p->x(), 1, 1e-12);
  EXPECT_NEAR(p->y(), -0.5, 1e-12);
  EXPECT_NEAR(p->z(), 1.25, 1e-12);
  EXPECT_NEAR(p->yaw(), 22.5 * kDegree, 1e-12);
  EXPECT_NEAR(p->pitch(), 0, 1e-12);
  EXPECT_NEAR(p->roll(), 0, 1e-12);
}

TEST(Trajectory, TurnsTheShortWayRound)
{
  const Trajectory t({{0, pose(0, 0, 0, 170)}, {1, pose(0, 0, 0, -170)}});
  EXPECT_NEAR(std::abs(t.at(0.5, 5)->yaw()), 180 * kDegree, 1e-9);
}

TEST(Trajectory, GivesNothingInALongGapOutsideOrForNoTimeButTheEntriesToAMillisecond)
{
  const Trajectory t({{0, pose(0)}, {1, pose(1)}, {5, pose(5)}});
  constexpr double kNone = -1, kInfinity = std::numeric_limits<double>::infinity();
  for (const auto& [time_s, max_gap_s, x_m] : std::vector<std::array<double, 3>>{
           {0.5, 1, 0.5},
           {3, 1, kNone},
           {3, 4, 3},
           {3, 3.999, kNone},
           {5, 1, 5},
           {4.9995, 1, 5},
           {1.0005, 1, 1},
           {4.998, 1, kNone},
           {-0.0005, 10, 0},
           {5.0005, 10, 5},
           {-0.01, 10, kNone},
           {5.01, 10, kNone},
           {-100, 1e9, kNone},
           {NAN, 10, kNone},
           {kInfinity, 10, kNone}})
  {
    const auto p = t.at(time_s, max_gap_s);
    EXPECT_DOUBLE_EQ(p ? p->x() : kNone, x_m) << time_s << " " << max_gap_s;
  }
  EXPECT_TRUE(Trajectory().empty());
  EXPECT_FALSE(Trajectory().at(0, 10));
}

TEST(Trajectory, RefusesTimesAndPosesThatAreNotFinite)
{
  EXPECT_THROW(Trajectory({{0, pose(0)}, {std::nan(""), pose(1)}}), std::invalid_argument);
  EXPECT_THROW(Trajectory({{0, pose(std::nan(""))}}), std::invalid_argument);
}

TEST(TumFile, ReadsPosesBetweenCommentsBlankLinesAndWindowsLineEnds)
{
  const ScratchDir dir;
  const auto t = load_text(
      dir,
      "# t x y z qx qy qz qw\r\n\r\n"
      "1725981157.851717 1.5 -2.25 3e-1 0 0 0 1\r\n"
      "  1725981158.0\t2 0 0 0 0 0.70710678 0.70710678 # turned left\n"
      "1725981156 0 0 0 0 0 0 -1");
  ASSERT_EQ(t.entries().size(), 3u);
  EXPECT_EQ(t.entries()[0].time_s, 1725981156.0);
  EXPECT_EQ(t.entries()[1].time_s, 1725981157.851717);
  EXPECT_EQ(t.entries()[1].T_map_base.x(), 1.5);
  EXPECT_EQ(t.entries()[1].T_map_base.y(), -2.25);
  EXPECT_EQ(t.entries()[1].T_map_base.z(), 0.3);
  EXPECT_NEAR(t.entries()[2].T_map_base.yaw(), 90 * kDegree, 1e-9);
}

TEST(TumFile, AcceptsAByteOrderMarkAndPlusSigns)
{
  const ScratchDir dir;
  const auto t = load_text(dir, "\xEF\xBB\xBF+1 +2.5 -0 0 0 0 0 +1\n");
  ASSERT_EQ(t.entries().size(), 1u);
  EXPECT_EQ(t.entries()[0].time_s, 1.0);
  EXPECT_EQ(t.entries()[0].T_map_base.x(), 2.5);
}

TEST(TumFile, NamesTheLineTheWordAndWhatIsWrong)
{
  using Words = std::vector<std::string>;
  const std::string good = "1 0 0 0 0 0 0 1\n";
  for (const auto& [text, words] : std::vector<std::pair<std::string, Words>>{
           {"# c\n" + good + "2 0 0 0 0 0 1\n", {"poses.tum:3:", "7 words", "qw"}},
           {"1 0 0 0 0 0 0 1 9.5\n", {"poses.tum:1:", "9 words"}},
           {"1 0 0 5 0 1 0 6 0 0 1 7\n", {"poses.tum:1:", "KITTI has no time", "TUM lines"}},
           {good + "2 0 zero 0 0 0 0 1\n", {"poses.tum:2:", "'zero'", "number"}},
           {"1 0 0 0 0 0 0 1x\n", {"poses.tum:1:", "'1x'"}},
           {"1,0,0,0,0,0,0,1 2 3 4 5 6 7 8\n", {"poses.tum:1:", "'1,0,0,0"}},
           {"1 +-2 0 0 0 0 0 1\n", {"poses.tum:1:", "'+-2'"}},
           {"1 0 0 nan 0 0 0 1\n", {"poses.tum:1:", "'nan'", "not finite"}},
           {"1 inf 0 0 0 0 0 1\n", {"poses.tum:1:", "'inf'", "not finite"}},
           {"nan 0 0 0 0 0 0 1\n", {"poses.tum:1:", "not finite"}},
           {"1 1e999 0 0 0 0 0 1\n", {"poses.tum:1:", "1e999"}},
           {"1 0 0 0 0 0 0 0\n", {"poses.tum:1:", "norm 0.0", "t x y z qx qy qz qw"}},
           {"1 0 0 0 0.3 0.2 0.1 0\n", {"poses.tum:1:", "norm 0.37"}},
           {"1725981157851717000 0 0 0 0 0 0 1\n", {"poses.tum:1:", "nanoseconds"}},
           {"# nothing\n\n", {"poses.tum", "no poses"}},
           {"1.7e+09 0 0 0 0 0 0 1\n1.7e+09 1 0 0 0 0 0 1\n", {"lost digits"}},
           {std::string("\x8d\x00\x01zz\n", 6), {"poses.tum:1:", "words"}},
           {good + "\n2 0 0 0 0 0 0 1\n1 0.5 0 0 0 0 0 1\n",
            {"poses.tum:4:", "line 1", "same time"}},
           {good + "1 0 0 0 0 0 0.70710678 0.70710678\n", {"poses.tum:2:", "same time"}}})
  {
    const ScratchDir dir;
    expect_error([&dir, bytes = text] { load_text(dir, bytes); }, words);
  }
  const ScratchDir dir;
  const auto t = load_text(dir, good + "1 0.01 0 0 0 0 0 -1\n");
  EXPECT_EQ(t.entries().size(), 1u) << "nearly the same pose twice";
}

TEST(TumFile, NormalisesQuaternionsThatWereRounded)
{
  const ScratchDir dir;
  const auto t = load_text(dir, "1 0 0 0 0 0 0.71 0.71\n");
  EXPECT_NEAR(t.entries()[0].T_map_base.yaw(), 90 * kDegree, 1e-9);
}

TEST(TumFile, MayHaveTheNumbersOfRtabMapsPoses)
{
  const ScratchDir dir;
  const auto t =
      load_text(dir, "#timestamp x y z qx qy qz qw id\n1 5 0 0 0 0 0 1 1\n2 6 0 0 0 0 0 1 2\n");
  EXPECT_EQ(t.at(2, 1)->x(), 6);
}

namespace
{
using Observations = std::vector<mrpt::obs::CObservation::Ptr>;

void add_keyframe(
    mrpt::maps::CSimpleMap& map, const CPose3D& T_map_base, const Observations& observations)
{
  auto frame = std::make_shared<mrpt::obs::CSensoryFrame>();
  for (const auto& obs : observations) frame->insert(obs);
  map.insert(std::make_shared<mrpt::poses::CPose3DPDFGaussian>(T_map_base), frame);
}

mrpt::maps::CSimpleMap two_keyframes(bool with_observations)
{
  mrpt::maps::CSimpleMap map;
  for (int i = 0; i < 2; ++i)
  {
    Observations observations;
    if (with_observations)
      observations = {observation_at<mrpt::obs::CObservationOdometry>(50 + 2 * i)};
    add_keyframe(map, pose(3.0 * i, 0, 0, 30 * i), observations);
  }
  return map;
}
}  // namespace

TEST(SimpleMapFile, GivesTheKeyframesAtTheTimesOfTheirObservations)
{
  const ScratchDir dir;
  for (const std::string name : {"a.simplemap", "b.simplemap.gz"})
  {
    two_keyframes(true).saveToFile(dir / name);
    const auto t = Trajectory::load(dir / name);
    ASSERT_EQ(t.entries().size(), 2u);
    EXPECT_NEAR(t.at(51, 2)->x(), 1.5, 1e-9);
    EXPECT_NEAR(t.at(51, 2)->yaw(), 15 * kDegree, 1e-9);
  }
}

TEST(SimpleMapFile, SaysWhenItsPosesBelongToNoTime)
{
  const ScratchDir dir;
  two_keyframes(false).saveToFile(dir / "a.simplemap");
  expect_error(
      [&] { Trajectory::load(dir / "a.simplemap"); },
      {"a.simplemap", "2 key frames", "time stamp"});
}

TEST(SimpleMapFile, RefusesPosesThatAreNotFinite)
{
  const ScratchDir dir;
  auto map = two_keyframes(true);
  add_keyframe(map, pose(std::nan("")), {observation_at<mrpt::obs::CObservationOdometry>(54)});
  map.saveToFile(dir / "a.simplemap");
  expect_error(
      [&] { Trajectory::load(dir / "a.simplemap"); },
      {"a.simplemap", "key frame 3 of 3", "not finite"});
}

TEST(SimpleMapFile, SaysWhenItIsTextOrCutShort)
{
  const ScratchDir dir;
  write_bytes(dir / "text.simplemap", "these are words, not a map\n");
  expect_error(
      [&] { Trajectory::load(dir / "text.simplemap"); },
      {"text.simplemap", "nothing of MRPT begins"});

  two_keyframes(true).saveToFile(dir / "a.simplemap");
  const auto bytes = read_bytes(dir / "a.simplemap");
  write_bytes(dir / "cut.simplemap", bytes.substr(0, bytes.size() / 2));
  expect_error([&] { Trajectory::load(dir / "cut.simplemap"); }, {"cut.simplemap", "cut short"});
}

namespace
{
/** A key frame each second of a robot that turns to the left at 1 m/s, as MRPT from 2.11 on writes
 * it, with twists or without. */
std::string newer_simplemap(bool has_twist, const std::string& comment)
{
  mrpt::io::CMemoryStream bytes;
  auto out = mrpt::serialization::archiveFrom(bytes);
  const std::string name = "mrpt::maps::CSimpleMap";
  out << static_cast<std::uint8_t>(name.size() | 0x80);
  out.WriteBuffer(name.data(), name.size());
  out << std::uint8_t{2} << std::uint32_t{2};
  for (int i = 0; i < 2; ++i)
  {
    mrpt::obs::CSensoryFrame frame;
    const auto text = observation_at<mrpt::obs::CObservationComment>(50 + i);
    text->text = comment;
    for (const mrpt::obs::CObservation::Ptr& obs : Observations{
             observation_at<mrpt::obs::CObservationOdometry>(49.95 + i), text,
             observation_at<mrpt::obs::CObservationPointCloud>(50 + i)})
      frame.insert(obs);
    out << mrpt::poses::CPose3DPDFGaussian(pose(std::sin(i), 1 - std::cos(i), 0, i / kDegree));
    out << frame << std::string("std::optional") << std::string("TTwist3D") << has_twist;
    if (has_twist) out << 1.0 << 0.0 << 0.0 << 0.0 << 0.0 << 1.0;
  }
  out << std::uint8_t{0x88};
  return {static_cast<const char*>(bytes.getRawBufferData()), bytes.getTotalBytesCount()};
}
}  // namespace

TEST(SimpleMapFile, SaysByItsTwistsOrVelocitiesWhereTheRobotWasDuringAScan)
{
  const ScratchDir dir;
  const std::string buffer =
      "local_velocity_buffer:\n  state:\n    linear_velocities:\n      -0.09: \"'[7 0 0]'\"\n"
      "      0.01: \"'[1 0 0]'\"\n    angular_velocities:\n      0.002: \"'[0 0 1]'\"\n";
  write_bytes(dir / "twist.simplemap", newer_simplemap(true, ""));
  write_bytes(dir / "buffer.simplemap", newer_simplemap(false, buffer));
  for (const char* name : {"twist.simplemap", "buffer.simplemap"})
    for (const double t : {0.0, 0.1, 0.8, 0.95, 1.2})
    {
      const auto p = Trajectory::load(dir / name).at(50 + t, 0.15);
      ASSERT_TRUE(p) << name << " " << t;
      EXPECT_NEAR(p->x(), std::sin(t), 0.002) << name << " " << t;
      EXPECT_NEAR(p->yaw(), t, 1e-6) << name << " " << t;
    }
  write_bytes(dir / "none.simplemap", newer_simplemap(false, "anything: else"));
  EXPECT_FALSE(Trajectory::load(dir / "none.simplemap").at(50.1, 0.15));
}

TEST(SimpleMapFile, ReadsTheOneThatComesWithMrpt)
{
  const auto path = stock_dataset("localization_demo.simplemap.gz");
  TALUS_SKIP_WITHOUT(path);
  EXPECT_GT(Trajectory::load(path).entries().size(), 10u);
}
