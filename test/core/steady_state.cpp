#include <gtest/gtest.h>
#include <talus/live_map.h>
#include "count_allocations.h"
#include "scene.h"

// A map that has seen its largest frame needs the heap no more. All allocations are counted.

using namespace talus;
using namespace talus::test;

namespace
{
constexpr int kScans = 20, kWarm = 60, kFrames = 200;

/** Scans of several sizes on a drive past boxes, some of them deskewed. */
class Drive
{
 public:
  Drive()
  {
    const std::vector<Box> boxes{{{2, 0.5, 0}, {2.3, 0.9, 0.5}}, {{4, -1, 0.75}, {4.6, 1, 0.8}}};
    for (int i = 0; i < kScans; i++)
    {
      scans_.emplace_back(0.07 * i, 0.02 * i, 0.7);
      scans_.back().cast(boxes, i % 3 ? 180 : 360, -0.6, 0.1, 16);
    }
    times_.resize(scans_.front().x_.size(), 0.01f);
    for (const Scan& s : scans_) frames_.push_back(frame(s));
  }

  const Frame& operator[](int i) const { return frames_[static_cast<std::size_t>(i % kScans)]; }

 private:
  Frame frame(const Scan& s) const
  {
    Frame f = s.frame();
    if (frames_.size() % 4) return f;
    f.time_s = times_.data();
    f.path = {{-0.05, s.pose_}, {0.05, s.pose_}};
    return f;
  }
  std::vector<Scan> scans_;
  std::vector<float> times_;
  std::vector<Frame> frames_;
};

const std::vector<Layer> kDelivered{Layer::Traversability, Layer::Elevation};

/** Allocations in so many frames, layers read after each, of a map that is warm. */
std::uint64_t allocations_when_warm(Parameters p, int threads, int frames = kFrames)
{
  p.window_m = 3;
  const Drive drive;
  ElevationMapper map(p, Backend::Cpu, threads);
  map.set_output_layers(kDelivered);
  const auto one = [&](int i)
  {
    map.update(drive[i]);
    for (const Layer l : {Layer::Traversability, Layer::Elevation, Layer::Variance, Layer::Slope})
      EXPECT_EQ(map.layer(l).size(), 60u * 60u);
  };
  for (int i = 0; i < kWarm; i++) one(i);
  const std::uint64_t before = allocations;
  for (int i = 0; i < frames; i++) one(i);
  return allocations - before;
}
}  // namespace

TEST(SteadyState, TheCounterCounts)
{
  const std::uint64_t before = allocations;
  const std::vector<int> some(100);
  EXPECT_EQ(allocations - before, 1u);
}

TEST(SteadyState, AThousandFramesAllocateNothing)
{
  EXPECT_EQ(allocations_when_warm({}, 1, 1000), 0u);
}

TEST(SteadyState, NeitherDoTheyWithAVoxelFilterAndManySamples)
{
  Parameters p;
  p.voxel_m = 0.05;
  p.fill_samples = 16;
  EXPECT_EQ(allocations_when_warm(p, 1), 0u);
}

TEST(SteadyState, NeitherDoFramesOfWhichTwoAreInFlight)
{
  const Drive drive;
  Parameters p;
  p.window_m = 3;
  ElevationMapper map(p, Backend::Cpu, 1);
  map.set_output_layers(kDelivered);
  map.start(drive[0]);
  std::uint64_t before = 0;
  for (int i = 1; i < kWarm + kFrames; i++)
  {
    if (i == kWarm) before = allocations;
    map.start(drive[i]);
    map.finish();
    for (const Layer l : kDelivered) EXPECT_EQ(map.layer(l).size(), 60u * 60u);
  }
  EXPECT_EQ(allocations - before, 0u);
}

TEST(SteadyState, FramesIntoALiveMapThatIsReadAllocateNothing)
{
  const Drive drive;
  LiveMap map({}, kDelivered, Backend::Cpu, 1);
  std::uint64_t of_ingestion = 0;
  for (int i = 0; i < kWarm + kFrames; i++)
  {
    Frame frame = drive[i];
    frame.stamp_s = 0.1 * i;
    const auto held = i % 3 ? map.snapshot() : nullptr;
    if (i == kWarm) of_ingestion = 0;
    const std::uint64_t before = allocations;
    map.ingest(frame);
    of_ingestion += allocations - before;
  }
  EXPECT_EQ(of_ingestion, 0u);
}

TEST(SteadyState, ThreadsAllocateTheirScratchOnce)
{
  // oneTBB starts a thread when it likes and gives it a share of a loop when it likes: it may meet
  // a loop for the first time long after the first frame. Its tasks come from a pool of its own.
  constexpr std::uint64_t kScratchArrays = 16;
  EXPECT_LE(allocations_when_warm({}, 2), 2 * kScratchArrays);
}

TEST(SteadyState, BytesOfACell)
{
  Parameters p;
  p.window_m = 40;
  const double cells = p.cells() * p.cells();
  const Scan scan = Scan().add(1, 1, 0);
  const std::uint64_t before = allocated_bytes;
  ElevationMapper map(p, Backend::Cpu, 1);
  map.update(scan.frame());
  const std::uint64_t all = allocated_bytes - before;
  // Resident: see performance.md. What says which window and sensor it is belongs to no cell.
  constexpr std::size_t of_sensor = 32;
  const std::size_t header = ElevationMapper(p, Backend::Cpu, 1).save().size() + of_sensor;
  ASSERT_LE(header, 128u);
  EXPECT_LE(static_cast<double>(map.save().size() - header) / cells, 44);
  EXPECT_LE(static_cast<double>(all) / cells, 129);  // and all that a frame works with
}
