// The command talus-calibrate from end to end: its files, messages and exit codes.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/poses/CPose3D.h>
#include <talus/io/rawlog_reader.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>

#include "command_run.h"

namespace fs = std::filesystem;
using talus::test::CommandEnd;

namespace
{
class TalusCalibrate : public talus::test::CommandTest
{
 protected:
  TalusCalibrate() : CommandTest(TALUS_CALIBRATE_EXE) {}
  void fails(const std::string& arguments, int code, const std::vector<std::string>& words) const
  {
    CommandTest::fails(arguments, code, words);
    EXPECT_FALSE(exists("out"));
  }
  /** drive.rawlog and drive.tum. */
  void simulate(
      const std::string& ground, const std::string& way, const std::string& more,
      const std::string& sensor = "{}") const
  {
    write(
        "drive.yaml",
        "ground: [" + ground + "]\nrobot: {path_m: " + way + "}\nsensor: " + sensor + "\n");
    done(TALUS_SIM_EXE " drive.yaml --output . --quiet " + more);
  }
};

const char* const kWaves =
    "{sine: {amplitude_m: 0.15, wavelength_m: 9, yaw_deg: 15}}, "
    "{sine: {amplitude_m: 0.06, wavelength_m: 4.5, yaw_deg: 100}}";
const char* const kWay = "[[0, 0], [4, 1.5], [7, -0.25]]";
// Of ten scans a second and all that they see, these take a third of the time.
const std::string kFewScans = "--every 4 ", kNear = "drive.rawlog --max-range 4 --output out";

double estimate_of(const nlohmann::json& calibration, const char* name)
{
  return calibration["parameters"][name]["estimate"].get<double>();
}

/** As talus-sim mounts it. */
void expect_true_mounting(const nlohmann::json& calibration)
{
  EXPECT_NEAR(estimate_of(calibration, "roll"), 0, 0.05);
  EXPECT_NEAR(estimate_of(calibration, "pitch"), 0, 0.05);
  EXPECT_NEAR(estimate_of(calibration, "z"), 0.68, 0.005);
}

TEST_F(TalusCalibrate, WritesWhatAStockToolPutsRight)
{
  simulate(kWaves, kWay, kFewScans + "--mounting-error 0,0,0.05,0,-3,2 --clock-error 0.05");
  fs::create_symlink(".", path("m\xfcll"));  // a name that is not UTF-8 costs no results
  const auto done = runs("m\xfcll/" + kNear);
  EXPECT_TRUE(done.says("held-out ground thickness")) << done.text;
  const auto json = this->json("out/calibration.json");
  expect_true_mounting(json);
  EXPECT_NEAR(estimate_of(json, "time_offset"), -0.05, 0.005);
  EXPECT_LT(json["held_out"]["after"]["thickness_m"], json["held_out"]["before"]["thickness_m"]);
  EXPECT_SAYS(text("out/calibration.ini"), "c_beam_m = ");
  EXPECT_EQ(text("out/calibration.png").substr(1, 3), "PNG");

  const auto edited =
      shell("rawlog-edit --sensors-pose out/sensors-pose.ini -i ./drive.rawlog -o ./fixed.rawlog");
  ASSERT_EQ(edited.code, 0) << edited.text;
  talus::io::RawlogReader fixed(path("fixed.rawlog"));
  const mrpt::poses::CPose3D mounting(fixed.next()->sensorPose());
  EXPECT_NEAR(mounting.z(), estimate_of(json, "z"), 1e-5);
  EXPECT_NEAR(mounting.pitch() * 57.29578, estimate_of(json, "pitch"), 1e-4);
  EXPECT_NEAR(mounting.roll() * 57.29578, estimate_of(json, "roll"), 1e-4);
}

TEST_F(TalusCalibrate, FindsASensorThatIsMountedUpsideDown)
{
  simulate(kWaves, kWay, kFewScans + "--mounting-error 0,0,0.05,0,-3,178");
  const auto done = runs(kNear);
  EXPECT_TRUE(done.says("mounted upside down")) << done.text;
  const auto json = this->json("out/calibration.json");
  expect_true_mounting(json);
}

TEST_F(TalusCalibrate, RefusesASensorOnItsSideAndOneWhoseYawIsHalfATurnWrong)
{
  for (const auto& [error, words] :
       {std::pair{"0,0,0,0,0,90", "drive.rawlog: "},
        std::pair{"0,0,0,180,0,0", "whose yaw is given 180 degrees wrong"}})
  {
    simulate(kWaves, kWay, kFewScans + "--mounting-error " + error);
    fails(kNear, 1, {words});
  }
}

TEST_F(TalusCalibrate, RecommendsNoFitThatTheHeldOutFramesHardlyLike)
{
  simulate(kWaves, "[[0, 0], [4, 1.5], [8, -1]]", kFewScans + "--mounting-error 0,0,0,20,0,0");
  const auto done = runs(kNear);
  EXPECT_TRUE(done.says("the fit is not recommended")) << done.text;
  EXPECT_FALSE(done.says("to paste")) << done.text;
  EXPECT_EQ(nlohmann::json::parse(text("out/calibration.json"))["recommended"], false);
}

TEST_F(TalusCalibrate, WritesNoFitThatMakesTheHeldOutFramesWorse)
{
  simulate(kWaves, kWay, kFewScans);
  // Only the frames that are fitted nod: every fifth, which is held out, is right as given.
  talus::io::RawlogReader drive(path("drive.rawlog"));
  talus::test::Objects scans;
  const mrpt::poses::CPose3D nod(0, 0, 0, 0, 3 / 57.29578, 0);
  for (int i = 0; const auto obs = drive.next(); ++i)
  {
    auto scan = std::dynamic_pointer_cast<mrpt::obs::CObservationPointCloud>(obs);
    ASSERT_TRUE(scan);
    if (i % 5 != 2) scan->pointcloud->changeCoordinatesReference(nod);
    scans.push_back(scan);
  }
  talus::test::write_log(path("drive.rawlog"), scans, talus::test::Packing::Plain);
  fails(kNear, 1, {"nothing was written", "held out"});
}

TEST_F(TalusCalibrate, StatesNoCertaintyOfANoiseThatIsNotTold)
{
  simulate(kWaves, kWay, kFewScans, "{noise_m: 0, noise_per_m: 0}");
  const auto done = runs(kNear);
  const auto json = this->json("out/calibration.json");
  ASSERT_FALSE(json["noise"]["c_beam_m"]["told_from_zero"]) << done.text;
  const std::string ini = text("out/calibration.ini");
  EXPECT_SAYS(ini, "c_beam_m = 0.0001   # not significant");
}

TEST_F(TalusCalibrate, SaysWhatIsMissingAndWritesNothing)
{
  simulate("{plane: {z_m: 0}}", "[[0, 0], [1, 0]]", "--frames 1");
  fails("drive.rawlog --output out", 1, {"motion"});
  simulate("{plane: {z_m: 0}}", "[[0, 0], [0.3, 0]]", "");
  fails("drive.rawlog --output out", 1, {"too few"});
  simulate("{plane: {z_m: 0}}", "[[0, 0], [2, 0]]", "");
  fails("drive.rawlog --max-range 1.5 --output out", 1, {"ground"});
  fs::rename(path("drive.rawlog"), path("calibration.json"));
  fails(
      "calibration.json --trajectory drive.tum --output .", 1,
      {"would be overwritten, but it is an input"});
}

TEST_F(TalusCalibrate, TellsWrongUseAndWrongFiles)
{
  fails("", 2, {});
  for (const std::string wrong :
       {"--noise loud", "--max-gap nan", "--max-offset nan", "--base-height nan", "--max-range nan",
        "--time-offset nan", "--mount nan,0,0,0,0,0", "--trajectory ''", "--output ''"})
    fails("a.rawlog " + wrong, 2, {});
  fails("--help", 0, {});
  fails("--version", 0, {"talus-calibrate "});
  fails("nowhere.rawlog", 1, {"nowhere.rawlog"});
}

}  // namespace
