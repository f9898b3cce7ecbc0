// Stamps of a clock that is not that of the recorder: since the sensor was switched on.
#include "bag_log.h"

using namespace talus;
using namespace talus::import;
using namespace talus::test;

namespace
{
SourceOptions recorded()
{
  SourceOptions options;
  options.recorded_times = true;
  return options;
}
}  // namespace

TEST(BagClock, ScansHaveTheTimesOfRecordingWhereTheyAreAskedFor)
{
  MAKE_BAGS("boot_clouds.mcap boot_all.mcap boot_odometry.mcap boot_moving.mcap");
  for (const std::string name :
       {"boot_clouds.mcap", "boot_all.mcap", "boot_odometry.mcap", "boot_moving.mcap"})
  {
    SCOPED_TRACE(name);
    const auto source = open_bag_source({dir / name}, recorded());
    const auto scans = all_of(*source);
    ASSERT_EQ(scans.size(), 10u);
    for (std::size_t i = 0; i < scans.size(); ++i)
    {
      EXPECT_NEAR(scans[i].time_s, kBagStart_s + 0.1 * static_cast<double>(i) + 0.01, 1e-6);
      expect_pose(scans[i].T_base_sensor, 0, 0, 1, 0);
      ASSERT_EQ(scans[i].point_time_s.size(), 2u);  // since the stamp of the same clock
      EXPECT_NEAR(scans[i].point_time_s[1], 0.05, 1e-5);
    }
    const auto poses = source->poses();
    ASSERT_EQ(poses.entries().size(), 10u);
    EXPECT_NEAR(poses.entries()[3].time_s, kBagStart_s + 0.3, 1e-6);
    EXPECT_TRUE(holds(remarks_of(dir / name, recorded()), "/points: 10 scans have the time of"));
  }
}

TEST(BagClock, WithoutTheSwitchTheStampsCount)
{
  MAKE_BAGS("boot_clouds.mcap boot_all.mcap");
  for (const std::string name : {"boot_clouds.mcap", "boot_all.mcap"})
    EXPECT_NEAR(scans_of(dir / name, "/points").at(1).time_s, 614.76, 1e-6) << name;
}

TEST(BagClock, MountingsOfAnotherTimeNameTheSwitch)
{
  MAKE_BAGS("boot_moving.mcap");
  const auto error = error_of(dir / "boot_moving.mcap");
  for (const char* part :
       {"none of its 10 scans", "614.66 s", "--recorded-times", "--mount /points"})
    EXPECT_TRUE(holds(error, part)) << part << " is not in: " << error;
}

TEST(BagClock, ScansOfAnotherClockThanThePosesAreToldWithBothMedians)
{
  MAKE_BAGS("ahead_37.mcap ahead_1.mcap ahead_all.mcap jump_2.mcap");
  const auto warnings = [&](const std::string& name, const SourceOptions& options)
  {
    const auto source = open_bag_source({dir / name}, options);
    all_of(*source);
    const auto all = source->warnings();
    return all.empty() ? "" : all[0];
  };
  const auto of_37 = warnings("ahead_37.mcap", {});
  for (const char* part : {"/points", "-36.98 s after", "0.00 s after", "--recorded-times"})
    EXPECT_TRUE(holds(of_37, part)) << part << " is not in: " << of_37;
  EXPECT_EQ(warnings("ahead_37.mcap", recorded()), "");
  EXPECT_EQ(warnings("ahead_1.mcap", {}), "");
  EXPECT_EQ(warnings("ahead_all.mcap", {}), "") << "of a recorder with another clock";
  const auto jump = warnings("jump_2.mcap", {});
  EXPECT_TRUE(holds(jump, "jumps") && holds(jump, "-1.98 to 0.02 s")) << jump;
}
