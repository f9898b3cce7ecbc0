#include <gtest/gtest.h>
#include <talus/live_map.h>
#include "scene.h"

#include <atomic>
#include <limits>
#include <thread>

using namespace talus;
using namespace talus::test;

namespace
{
const std::vector<Layer> kLayers{Layer::Traversability, Layer::Elevation, Layer::State};
const Parameters kSmallWindow = with({{"window_m", 4}});

/** Frame `i` of a drive past a box, ten a second. */
class Drive
{
 public:
  explicit Drive(int frames)
  {
    for (int i = 0; i < frames; i++)
    {
      scans_.emplace_back(0.06 * i, 0, 0.7);
      scans_.back().cast({{{1.5, -0.5, 0}, {1.8, 0.2, 0.4}}}, 90, -0.6, 0.1, 12);
    }
  }
  int size() const { return static_cast<int>(scans_.size()); }
  Frame operator[](int i) const { return scans_[static_cast<std::size_t>(i)].frame(100 + 0.1 * i); }

 private:
  std::vector<Scan> scans_;
};

using Bits = std::vector<std::vector<float>>;

template <class Map>
Bits bits_of(const Map& map)
{
  Bits bits;
  for (const Layer l : kLayers) bits.push_back(map.layer(l));
  return bits;
}

bool same(const Bits& a, const Bits& b)
{
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_bits);
}

/** The layers after each frame of a drive, [0] before the first. */
std::vector<Bits> expected_bits(const Drive& drive)
{
  ElevationMapper map(kSmallWindow, tested_backend());
  std::vector<Bits> expected{{}};
  for (int i = 0; i < drive.size(); i++)
  {
    map.update(drive[i]);
    expected.push_back(bits_of(map));
  }
  return expected;
}

/** What a thread sees that looks at a map again and again. */
struct Watcher
{
  const LiveMap& map;
  const std::vector<Bits>& expected;
  const Drive& drive;
  std::atomic<int>& wrong;
  std::atomic<int>& seen;

  void watch(const std::atomic<bool>& go_on) const
  {
    std::uint64_t last = 0;
    while (go_on)
    {
      const auto snapshot = map.snapshot();
      if (!snapshot || snapshot->frame == last) continue;
      if (snapshot->frame < last || !is_whole(*snapshot)) wrong++;
      last = snapshot->frame;
      seen++;
    }
  }
  bool is_whole(const MapSnapshot& s) const
  {
    const Frame frame = drive[static_cast<int>(s.frame) - 1];
    return s.report.stamp_s == frame.stamp_s && s.T_map_sensor.x() == frame.T_map_sensor.x() &&
           std::abs(s.window.min_x_m() + 2 - frame.T_map_sensor.x()) < 0.05001 &&
           same(bits_of(s), expected[s.frame]);
  }
};
}  // namespace

TEST(LiveMap, ShowsAScanWhenItsLastPartHasCome)
{
  const Drive drive(1);
  LiveMap map(kSmallWindow, kLayers, tested_backend());
  std::vector<std::uint64_t> shown;
  for (int i = 0; i <= 20; i++)
  {
    Frame part = drive[0];
    part.stamp_s = 0.01 * i;
    EXPECT_EQ(map.ingest(part), FrameOrder::Newest);
    shown.push_back(map.snapshot()->frame);
  }
  EXPECT_EQ(shown[9], 1u);
  EXPECT_EQ(shown[10], 2u);
  EXPECT_EQ(shown[19], 2u);
  EXPECT_EQ(shown[20], 3u);
  EXPECT_EQ(map.snapshot()->report.points_in, 10 * drive[0].size);
  map.clear();
  Frame first = drive[0];
  first.stamp_s = 0.205;
  map.ingest(first);
  EXPECT_EQ(map.snapshot()->report.points_in, first.size);
}

namespace
{
struct Stamp
{
  double stamp_s;
  FrameOrder order;
  std::uint32_t sensor = 0;
};
void expect_orders(const std::vector<Stamp>& stamps)
{
  FrameSequence sequence(1.0);
  for (const auto& [stamp_s, order, sensor] : stamps)
    EXPECT_EQ(sequence.next(stamp_s, sensor), order) << stamp_s << " of sensor " << sensor;
}
constexpr FrameOrder kNewest = FrameOrder::Newest, kDuplicate = FrameOrder::Duplicate,
                     kLate = FrameOrder::Late, kSetBack = FrameOrder::ClockSetBack;
}  // namespace

TEST(FrameSequence, SaysHowAFrameStandsToThoseBefore)
{
  expect_orders(
      {{100.0, kNewest},
       {100.1, kNewest},
       {100.1, kDuplicate},
       {100.0, kLate},
       {99.2, kLate},
       {100.2, kNewest},
       {99.1, kSetBack},
       {99.2, kNewest}});
}

TEST(FrameSequence, JudgesEachSensorByItselfAndAWrongStampInTheFutureCostsNothingButItself)
{
  expect_orders({{100.0, kNewest}, {1e9, kNewest}, {100.1, kSetBack}, {100.2, kNewest}});
  expect_orders(
      {{100.0, kNewest, 0},
       {99.95, kNewest, 1},
       {100.0, kNewest, 1},
       {100.0, kDuplicate, 0},
       {99.98, kLate, 1},
       {50.0, kNewest, 2}});
}

TEST(FrameSequence, RefusesWhatIsNoTime)
{
  FrameSequence sequence;
  EXPECT_THROW(sequence.next(std::nan("")), std::invalid_argument);
  EXPECT_THROW(sequence.next(std::numeric_limits<double>::infinity()), std::invalid_argument);
  EXPECT_THROW(FrameSequence(-1), std::invalid_argument);
  EXPECT_THROW(FrameSequence(std::nan("")), std::invalid_argument);
}

TEST(LiveMap, FramesOfTwoSensorsMayComeInterleaved)
{
  const Drive drive(6);
  LiveMap live(kSmallWindow, kLayers, tested_backend());
  for (int i = 0; i < drive.size(); i++)
    for (const std::uint32_t sensor : {0u, 1u})
    {
      Frame frame = drive[i];
      frame.sensor = sensor;
      frame.stamp_s -= 0.03 * sensor;  // it comes behind frames with a later stamp
      EXPECT_EQ(live.ingest(frame), FrameOrder::Newest) << i;
      EXPECT_EQ(live.ingest(frame), FrameOrder::Duplicate) << i;
    }
  EXPECT_EQ(live.counts().mapped, 12u);
  EXPECT_EQ(live.counts().duplicate, 12u);
}

TEST(LiveMap, DuplicatesAndLateFramesLeaveNoTraceAndItGoesOnWhenTheClockWasSetBack)
{
  const Drive drive(8);
  const auto expected = expected_bits(drive);
  LiveMap map(kSmallWindow, kLayers, tested_backend());
  EXPECT_EQ(map.snapshot(), nullptr);
  for (int i = 0; i < drive.size(); i++)
  {
    Frame frame = drive[i], late = drive[std::max(i - 2, 0)];
    for (Frame* f : {&frame, &late}) f->stamp_s -= i >= 6 ? 3600 : 0;
    EXPECT_EQ(map.ingest(frame), i == 6 ? FrameOrder::ClockSetBack : FrameOrder::Newest);
    EXPECT_EQ(map.ingest(frame), FrameOrder::Duplicate);
    if (i < 2) continue;
    EXPECT_EQ(map.ingest(late), FrameOrder::Late);
    ASSERT_TRUE(same(bits_of(*map.snapshot()), expected[static_cast<std::size_t>(i) + 1])) << i;
  }
  const LiveCounts counts = map.counts();
  EXPECT_EQ(counts.mapped, 8u);
  EXPECT_EQ(counts.duplicate, 8u);
  EXPECT_EQ(counts.late, 6u);
  EXPECT_EQ(counts.clock_set_back, 1u);
}

TEST(LiveMap, AFrameThatIsRefusedChangesNothing)
{
  const Drive drive(2);
  LiveMap map(kSmallWindow, kLayers, tested_backend());
  map.ingest(drive[0]);
  Frame broken = drive[1];
  broken.T_map_sensor.m[3] = std::nan("");
  EXPECT_THROW(map.ingest(broken), std::invalid_argument);
  broken = drive[1];
  broken.stamp_s = std::nan("");
  EXPECT_THROW(map.ingest(broken), std::invalid_argument);
  EXPECT_EQ(map.snapshot()->frame, 1u);
  EXPECT_EQ(map.ingest(drive[1]), FrameOrder::Newest);  // its stamp was not taken for seen
  EXPECT_TRUE(same(bits_of(*map.snapshot()), expected_bits(drive).back()));
}

TEST(LiveMap, ASnapshotHasTheLayersThatWereAskedForAndStaysAsItIsWhenTheMapIsCleared)
{
  const Drive drive(12);
  const auto expected = expected_bits(drive);
  auto map = std::make_unique<LiveMap>(kSmallWindow, kLayers, tested_backend());
  std::vector<std::shared_ptr<const MapSnapshot>> held;
  for (int i = 0; i < drive.size(); i++)
  {
    map->ingest(drive[i]);
    if (i % 2) held.push_back(map->snapshot());
  }
  EXPECT_THROW(held[0]->layer(Layer::Slope), std::invalid_argument);
  EXPECT_EQ(held[0]->parameters.window_m, 4.0);
  map->clear();
  EXPECT_EQ(map->snapshot(), nullptr);
  EXPECT_EQ(map->ingest(drive[0]), FrameOrder::Newest) << "the time of the last one is forgotten";
  EXPECT_TRUE(same(bits_of(*map->snapshot()), expected[1])) << "the map is forgotten";
  EXPECT_EQ(map->snapshot()->frame, 13u) << "and not taken for an earlier one by who holds that";
  EXPECT_EQ(map->counts().mapped, 13u);
  map.reset();
  for (const auto& snapshot : held)
    EXPECT_TRUE(same(bits_of(*snapshot), expected[snapshot->frame]));
}

TEST(LiveMap, ReadersSeeWholeFramesWhileOthersComeIn)
{
  const Drive drive(150);
  const auto expected = expected_bits(drive);
  LiveMap map(kSmallWindow, kLayers, tested_backend());
  std::atomic<bool> go_on{true};
  std::atomic<int> wrong{0}, seen{0};
  const Watcher watcher{map, expected, drive, wrong, seen};
  std::vector<std::thread> readers;
  for (int i = 0; i < 3; i++) readers.emplace_back([&] { watcher.watch(go_on); });
  for (int i = 0; i < drive.size(); i++)
  {
    map.ingest(drive[i]);
    if (i % 10 == 0) std::this_thread::yield();
  }
  while (seen == 0) std::this_thread::yield();
  go_on = false;
  for (auto& r : readers) r.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(seen, 1);
  EXPECT_TRUE(same(bits_of(*map.snapshot()), expected.back()));
}

TEST(LiveMap, SeveralThreadsMayFeedIt)
{
  const Drive drive(60);
  constexpr double kAnyTime_s = 1e3;  // a thread may be overtaken by any number of frames
  LiveMap map(kSmallWindow, kLayers, tested_backend(), 1, kAnyTime_s);
  std::atomic<int> next{0};
  const auto feed = [&]
  {
    for (int i = next++; i < drive.size(); i = next++) map.ingest(drive[i]);
  };
  std::thread a(feed), b(feed);
  a.join();
  b.join();
  const LiveCounts counts = map.counts();
  EXPECT_EQ(counts.mapped + counts.late, 60u);  // whoever was overtaken is late
  EXPECT_EQ(counts.duplicate + counts.clock_set_back, 0u);
  EXPECT_EQ(map.snapshot()->frame, counts.mapped);
}
