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
      EXPECT_NEAR(scans[i].time_s, kBagStart_s + 0.1 * static_cast<double>(i) + 0.01 - 0.05, 1e-6);
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

TEST(BagClock, ScansOfAnotherClockThanThePosesAreToldAndWantThatOfTheRecorder)
{
  MAKE_BAGS(
      "ahead_37.mcap ahead_1.mcap ahead_all.mcap jump_2.mcap boot_odometry.mcap stall.mcap "
      "sweep_end.mcap");
  struct Row
  {
    const char* name;
    std::vector<const char*> warning;
    bool wants, all;  //!< the recorder's clock, for poses too
  };
  for (const Row& row :
       {Row{"ahead_37.mcap",
            {"/points", "-36.98 s after", "0.00 s after", "--recorded-times"},
            true,
            false},
        {"ahead_1.mcap", {"0.98 s before their last points", "--recorded-times"}, false, false},
        {"sweep_end.mcap", {"0.08 s before their last points"}, false, false},
        {"stall.mcap", {}, false, false},
        {"ahead_all.mcap", {}, false, false},
        {"boot_odometry.mcap", {"/points", "--recorded-times"}, true, true},
        {"jump_2.mcap", {"jumps", "-1.98 to 0.02 s"}, true, false}})
  {
    SCOPED_TRACE(row.name);
    SourceOptions options;
    const auto first = open_bag_source({dir / row.name}, options);
    const auto scans = all_of(*first);
    const auto told = first->warnings();
    ASSERT_EQ(told.empty(), row.warning.empty());
    for (const char* part : row.warning) EXPECT_TRUE(holds(told[0], part)) << told[0];
    SourceOptions stamped;
    stamped.stamped_times = true;
    EXPECT_EQ(first->wants(options), row.wants);
    EXPECT_EQ(options.recorded_times, row.all);
    const auto again = open_bag_source({dir / row.name}, options);
    EXPECT_EQ(all_of(*again).size(), scans.size());
    EXPECT_EQ(again->warnings().empty(), row.wants || row.warning.empty());
    EXPECT_FALSE(again->wants(options));
    const auto as_asked = open_bag_source({dir / row.name}, stamped);
    all_of(*as_asked);
    EXPECT_FALSE(as_asked->wants(stamped));
  }
}
