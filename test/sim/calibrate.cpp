// libs/calibrate: derivatives, what is observable, the noise, what a log must have.
#include <gtest/gtest.h>
#include <talus/calibrate/calibrate.h>
#include <talus/calibrate/associate.h>
#include <talus/calibrate/held_out.h>
#include <talus/calibrate/information.h>
#include <talus/sim/drive.h>

#include <cmath>

#include "message_of.h"

using namespace talus;
using namespace talus::calibrate;

namespace
{
constexpr double kDegree = 3.14159265358979323846 / 180;

mrpt::poses::CPose3D to_mrpt(const Pose& T)
{
  mrpt::math::CMatrixDouble33 R;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) R(r, c) = T.m[4 * r + c];
  return mrpt::poses::CPose3D(R, mrpt::math::CMatrixDouble31({T.x(), T.y(), T.z()}));
}

/** A simulated drive whose log states a wrong mounting and clock. */
struct WrongLog
{
  Vector truth, given;
  PoseTrack track;
  ScanSet scans;
};

WrongLog wrong_log(
    const std::string& ground, const std::string& path, double roll_deg, double pitch_deg,
    double z_m, double clock_s, int frames, double late_nod_deg = 0)
{
  const auto world = sim::parse_world(
      "ground:\n" + ground + "robot: {path_m: " + path +
          "}\nsensor: {noise_m: 0.015, noise_per_m: 0.001}\n",
      "test.yaml");
  sim::DriveOptions options;
  options.frames = frames;
  const sim::Drive drive(world, options);
  const Vector truth = vector_of(to_mrpt(world.sensors[0].T_base_sensor), -clock_s);
  Vector given = truth;
  given[kRoll] += roll_deg * kDegree;
  given[kPitch] += pitch_deg * kDegree;
  given[kZ] += z_m;
  given[kTimeOffset] = 0;
  std::vector<io::Trajectory::Entry> poses;
  for (int i = 0; i < drive.frames(); ++i)
    poses.push_back({drive.time_s(i), to_mrpt(drive.T_map_base(i))});
  WrongLog log{
      truth, given, PoseTrack(io::Trajectory(poses), 0.5), ScanSet(Thinning{}, pose_of(given), 0)};
  for (int i = 0; i < drive.frames(); ++i)
  {
    auto s = drive.scan(i);
    const auto nod = static_cast<float>(i >= frames / 2 ? late_nod_deg * kDegree : 0);
    for (std::size_t k = 0; k < s.size(); ++k) s.z_m[k] -= nod * s.x_m[k];
    log.scans.add(
        drive.time_s(i) + clock_s, s.x_m.data(), s.y_m.data(), s.z_m.data(), nullptr, s.size());
  }
  return log;
}

const char* const kSwells =
    "  - sine: {amplitude_m: 0.15, wavelength_m: 9, yaw_deg: 15}\n"
    "  - sine: {amplitude_m: 0.06, wavelength_m: 4.5, yaw_deg: 100}\n";

Options options_of(const WrongLog& log)
{
  Options o;
  o.given = log.given;
  o.most_samples = 20000;  // fast; the limits below are met all the same
  return o;
}

TEST(CalibrateResidual, DerivativesAreThoseOfFiniteDifferences)
{
  const WrongLog log = wrong_log(kSwells, "[[0, 0], [2, 1], [4, 0]]", 2, -3, 0.05, 0.04, 20);
  Geometry g;
  for (const bool along_beam : {false, true})
    for (std::uint32_t view = 5; view < 8; ++view)
    {
      const Eigen::Vector3d p = log.scans.point(log.scans.views()[view].first + 40);
      evaluate_geometry(log.scans, log.track, log.given, g);
      const TrackPose& pose = g.views[view];
      const Eigen::Vector3d at = pose.R * (g.mounting.R * p + g.mounting.t_m) + pose.t_m;
      const Eigen::Vector2d center = at.head<2>() + Eigen::Vector2d(0.1, -0.2);
      Plane plane(at.z() + 0.02, 0.05, -0.03);
      const auto value = [&](const Vector& v)
      {
        evaluate_geometry(log.scans, log.track, v, g);
        return along_beam ? beam_to_plane(g, view, p, center, plane, 0.2)
                          : point_to_plane(g, view, p, center, plane);
      };
      const Residual r = value(log.given);
      constexpr double kStep = 1e-6;
      for (int i = 0; i < kParameters; ++i)
      {
        const Vector step = kStep * Vector::Unit(i);
        const double numeric =
            (value(log.given + step).distance_m - value(log.given - step).distance_m) / (2 * kStep);
        // The pose's own velocity is a difference over 1 ms.
        EXPECT_NEAR(r.by_parameters[i], numeric, 2e-4 * (1 + std::abs(numeric))) << i;
      }
      for (int i = 0; i < 3; ++i)
      {
        const Plane before = plane;
        plane[i] = before[i] + kStep;
        const double high = value(log.given).distance_m;
        plane[i] = before[i] - kStep;
        const double low = value(log.given).distance_m;
        plane = before;
        EXPECT_NEAR(r.by_plane[i], (high - low) / (2 * kStep), 1e-5);
      }
    }
}

TEST(CalibratePoseTrack, GoesThroughThePosesAndHasNoJumpsInItsVelocity)
{
  std::vector<io::Trajectory::Entry> poses;
  for (int i = 0; i < 10; ++i)
    poses.push_back({0.1 * i, mrpt::poses::CPose3D(std::sin(0.3 * i), 0, 0, 0.2 * i, 0, 0)});
  const PoseTrack track(io::Trajectory(poses), 0.5);
  for (int i = 1; i < 9; ++i)
  {
    EXPECT_NEAR(track.at(0.1 * i).t_m.x(), std::sin(0.3 * i), 1e-9);
    const double jump = (track.at(0.1 * i + 2e-3).dt_mps - track.at(0.1 * i - 2e-3).dt_mps).norm();
    EXPECT_LT(jump, 0.1);  // linear interpolation would jump by up to 0.9 m/s^2 * 0.1 s per pose
  }
  EXPECT_FALSE(track.covers(-0.1));
  EXPECT_TRUE(track.covers(0.45));
}

TEST(CalibratePoseTrack, TakesAsLongAsItsPosesWhereOneIsOfAnotherYear)
{
  std::vector<io::Trajectory::Entry> poses{{0, mrpt::poses::CPose3D()}};
  for (int i = 0; i < 10; ++i)
    poses.push_back({1.7e9 + 0.1 * i, mrpt::poses::CPose3D(0.1 * i, 0, 0.5, 0, 0, 0)});
  const auto places = driven_places(PoseTrack(io::Trajectory(poses), 0.5), 0.5);
  ASSERT_GT(places.size(), 20U);
  EXPECT_NEAR(places[1].time_s, 1.7e9, 0.01);
  EXPECT_NEAR(places.back().time_s, 1.7e9 + 0.9, 0.04);
}

TEST(CalibrateFirstGuess, IsRightToADegreeWhereTheGroundIsLevelOnAverage)
{
  const WrongLog log = wrong_log(
      "  - sine: {amplitude_m: 0.04, wavelength_m: 3}\n", "[[0, 0], [4, 2], [8, 0]]", 5, -5, 0.1, 0,
      60);
  const Vector v = level_mounting(log.scans, log.given);
  EXPECT_NEAR(v[kRoll], log.truth[kRoll], 1.0 * kDegree);
  EXPECT_NEAR(v[kPitch], log.truth[kPitch], 1.0 * kDegree);
  EXPECT_NEAR(v[kZ], log.truth[kZ], 0.04);
}

TEST(CalibrateFirstGuess, RefusesAGroundThatLeansUnderTheRobot)
{
  const WrongLog log = wrong_log(
      "  - sine: {amplitude_m: 0.04, wavelength_m: 3}\n", "[[0, 0], [4, 2]]", 20, 0, 0, 0, 40);
  EXPECT_NO_THROW(require_level_ground(log.scans, log.truth));
  EXPECT_THROW(require_level_ground(log.scans, log.given), std::runtime_error);
}

TEST(Calibrate, FindsMountingClockAndNoiseOnRollingGround)
{
  const WrongLog log =
      wrong_log(kSwells, "[[0, 0], [4, 1.5], [8, -1], [11, 1]]", 4, -3, 0.08, 0.07, 110);
  const Result r = talus::calibrate::calibrate(log.scans, log.track, options_of(log));
  EXPECT_NEAR(r.estimate[kRoll], log.truth[kRoll], 0.05 * kDegree);
  EXPECT_NEAR(r.estimate[kPitch], log.truth[kPitch], 0.05 * kDegree);
  EXPECT_NEAR(r.estimate[kZ], log.truth[kZ], 0.005);
  EXPECT_NEAR(r.estimate[kTimeOffset], log.truth[kTimeOffset], 0.005);
  EXPECT_TRUE(r.noise.model.along_beam);
  EXPECT_NEAR(r.noise.model.c_beam_m, 0.015, 0.0015);
  EXPECT_NEAR(r.noise.model.a_beam, 0.001, 0.0002);  // few points: 2 sigma of this fit
  EXPECT_LT(r.held_out.after.thickness_m, 0.2 * r.held_out.before.thickness_m);
  for (const int i : {kRoll, kPitch, kZ, kTimeOffset}) EXPECT_TRUE(r.observable[i]) << i;
}

TEST(Calibrate, NamesWhatAStraightDriveOnAFloorDoesNotTell)
{
  const WrongLog log = wrong_log("  - plane: {z_m: 0}\n", "[[0, 0], [5, 0]]", 1, 2, 0.05, 0, 50);
  const Result r = talus::calibrate::calibrate(log.scans, log.track, options_of(log));
  for (const int i : {kX, kY, kYaw, kTimeOffset})
  {
    EXPECT_FALSE(r.observable[i]) << i;
    EXPECT_EQ(r.estimate[i], log.given[i]) << i;
  }
  EXPECT_NEAR(r.estimate[kPitch], log.truth[kPitch], 0.05 * kDegree);
  EXPECT_NEAR(r.estimate[kZ], log.truth[kZ], 0.005);
}

TEST(Calibrate, HalvesThatDisagreeWidenTheDeviations)
{
  const auto sigma_of = [](double late_nod_deg)
  {
    const WrongLog log =
        wrong_log(kSwells, "[[0, 0], [4, 1.5], [8, -1]]", 0, 0, 0, 0, 40, late_nod_deg);
    return calibrate::calibrate(log.scans, log.track, options_of(log)).sigma[kPitch];
  };
  EXPECT_GT(sigma_of(0.3), 3 * sigma_of(0)) << "one half is pitched by 0.3 degrees";
}

TEST(Calibrate, WithoutContactTheHeightOverAFloorIsNotObservable)
{
  const WrongLog log = wrong_log("  - plane: {z_m: 0}\n", "[[0, 0], [5, 0]]", 0, 1, 0.05, 0, 50);
  Options o = options_of(log);
  o.use_contact = false;
  const Result r = talus::calibrate::calibrate(log.scans, log.track, o);
  EXPECT_FALSE(r.observable[kZ]);
  EXPECT_EQ(r.estimate[kZ], log.given[kZ]);
  EXPECT_TRUE(r.observable[kPitch]);
  EXPECT_FALSE(r.observable[kRoll]);  // a floor that leans sideways looks the same
}

TEST(CalibrateObservability, GivesUpWhatOnlyNoiseInThePlanesSeemsToTell)
{
  Information info;
  info.normal = 1e8 * Matrix::Identity();
  info.feigned(kX, kX) = 0.95e8;
  Choice all;
  all.fill(true);
  const Choice seen = observable(info, all);
  for (int i = 0; i < kParameters; ++i) EXPECT_EQ(seen[i], i != kX) << i;
}

TEST(Calibrate, SaysThatALogOfARobotAtRestLacksMotion)
{
  const WrongLog log = wrong_log("  - plane: {z_m: 0}\n", "[[0, 0], [0.2, 0]]", 0, 0, 0, 0, 90);
  const auto calibrate = [&]
  { talus::calibrate::calibrate(log.scans, log.track, options_of(log)); };
  EXPECT_TRUE(has(message_of(calibrate), "too few"));
}

TEST(CalibrateScanSet, KeepsTheSamePointsEveryTimeAndHalvesWhenThereAreTooMany)
{
  Thinning thinning;
  thinning.most_points = 5000;
  std::vector<float> x, y, z;
  for (int i = 0; i < 4000; ++i)
  {
    x.push_back(1.0F + 0.001F * static_cast<float>(i));
    y.push_back(0);
    z.push_back(-0.5F);
  }
  const auto make = [&]
  {
    ScanSet set(thinning, mrpt::poses::CPose3D(0, 0, 0.5, 0, 0, 0), 0);
    for (int f = 0; f < 6; ++f) set.add(0.1 * f, x.data(), y.data(), z.data(), nullptr, x.size());
    return set;
  };
  const ScanSet a = make(), b = make();
  EXPECT_LE(a.points(), 5000u);
  EXPECT_GT(a.points(), 1500u);
  ASSERT_EQ(a.points(), b.points());
  for (std::uint32_t i = 0; i < a.points(); i += 97) EXPECT_EQ(a.point(i), b.point(i));
  EXPECT_TRUE(a.held_out(2));
  EXPECT_FALSE(a.held_out(3));
}

}  // namespace
