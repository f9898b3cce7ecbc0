#include <gtest/gtest.h>
#include "exact_scene.h"
#include "street.h"

#include <talus/point_labels.h>

#include <cstddef>
#include <cstring>

using namespace talus;
using namespace talus::test;

// The same frames give the same bits on cores and on a device: every layer, after every frame.

namespace
{
/** A map on the CPU and one on the device that are fed alike. */
class Pair
{
 public:
  explicit Pair(const Parameters& p = {}) : cpu(p, Backend::Cpu, 2), cuda(p, Backend::Cuda) {}

  /** `other` holds the same points, perhaps in another order. */
  void update(const Frame& frame, const Frame& other)
  {
    const FrameReport a = cpu.update(frame), b = cuda.update(other);
    ASSERT_EQ(a.rejected, b.rejected) << "frame " << frames_;
    ASSERT_EQ(a.points_accepted, b.points_accepted) << "frame " << frames_;
    expect_same_bits();
    ASSERT_EQ(label_points(cpu, frame), label_points(cuda, frame)) << "frame " << frames_;
    frames_++;
  }
  void update(const Scan& s) { update(s.frame(), s.frame()); }

  void expect_same_bits() const
  {
    for (int l = 0; l < kLayerCount; l++)
      expect_same_bits(
          cpu.layer(static_cast<Layer>(l)), cuda.layer(static_cast<Layer>(l)), kLayerTable[l].name);
    for (const std::string& name : channel_layer_names(cpu.parameters().channels))
      expect_same_bits(cpu.channel(name), cuda.channel(name), name);
  }
  void expect_same_bits(
      const std::vector<float>& x, const std::vector<float>& y, const std::string& name) const
  {
    ASSERT_TRUE(same_bits(x, y)) << name << " differs after frame " << frames_ << ": "
                                 << first_difference(x, y);
  }

  ElevationMapper cpu, cuda;

 private:
  static std::string first_difference(const std::vector<float>& x, const std::vector<float>& y)
  {
    std::size_t count = 0, first = x.size();
    for (std::size_t i = x.size(); i-- > 0;)
      if (std::memcmp(&x[i], &y[i], sizeof(float)) != 0) count++, first = i;
    return std::to_string(count) + " cells, the first " + std::to_string(first) + ", " +
           std::to_string(x[first]) + " and " + std::to_string(y[first]);
  }
  int frames_ = 0;
};

/** Turns and tilts the sensor; the points keep their coordinates in its frame. */
void rotate(Scan& s, double yaw_rad, double pitch_rad)
{
  s.pose_ = ExactScene::pose(
      s.pose_.x(), s.pose_.y(), s.pose_.z(), std::tan(yaw_rad / 2), std::tan(pitch_rad / 2));
}
}  // namespace

TEST(Parity, ADriveWithPointsInAnotherOrderOnTheDevice)
{
  Pair maps;
  Random noise(1), order(2);
  for (int i = 0; i < 150; i++)
  {
    const Scan s = drive_frame(i, noise);
    ASSERT_NO_FATAL_FAILURE(maps.update(s.frame(), shuffled(s, order).frame()));
  }
}

TEST(Parity, ATurningAndTiltingSensorWithABodyAndAVoxelFilter)
{
  Parameters p;
  p.voxel_m = 0.05;
  p.body_boxes_m = {{-0.4, 0.4, -0.3, 0.3, -0.8, 0.1}};
  Pair maps(p);
  Random noise(3), order(4);
  for (int i = 0; i < 60; i++)
  {
    Scan s = drive_frame(i, noise);
    rotate(s, 0.05 * i, 0.1 * std::sin(0.3 * i));
    ASSERT_NO_FATAL_FAILURE(maps.update(s.frame(), shuffled(s, order).frame()));
  }
}

TEST(Parity, TwoTiltedSensorsFarFromTheBaseThatSeeTheRobot)
{
  for (const double voxel_m : {0.0, 0.05})
  {
    Parameters p;
    p.voxel_m = voxel_m;
    p.body_boxes_m = {{-0.4, 0.4, -0.3, 0.3, 0.1, 0.8}, {1.0, 1.6, -0.2, 0.2, 0.0, 0.3}};
    Pair maps(p);
    Random noise(13), order(14);
    for (int i = 0; i < 40; i++)
    {
      Scan s = drive_frame(i, noise), mixed = shuffled(s, order);
      const bool ahead = i % 2 == 0;
      rotate(s, ahead ? 0.1 : 3.0, ahead ? 0.4 : -0.1);
      Frame frame = s.frame(0.1 * i), other = mixed.frame(0.1 * i);
      frame.T_base_sensor = s.pose_;  // the base is level, on the ground, and goes along
      frame.T_base_sensor->m[3] = ahead ? 1.4 : -0.5;
      frame.sensor = ahead ? 3 : 9;
      other.T_map_sensor = frame.T_map_sensor;
      other.T_base_sensor = frame.T_base_sensor;
      other.sensor = frame.sensor;
      const std::vector<float> times(s.x_.size(), 0.03f);
      if (i % 5 == 0)
      {
        frame.path = other.path = {{0, s.pose_}, {0.1, s.pose_}};
        frame.time_s = other.time_s = times.data();
      }
      ASSERT_NO_FATAL_FAILURE(maps.update(frame, other));
    }
  }
}

namespace
{
/** Values of each point that its place decides, so that they go along when points change places. */
struct ChannelsOf
{
  explicit ChannelsOf(const Scan& s)
  {
    for (std::size_t i = 0; i < s.x_.size(); i++)
    {
      std::uint32_t bits;
      std::memcpy(&bits, &s.x_[i], sizeof bits);
      const float v = s.y_[i] * s.y_[i] * 1e3f + s.z_[i];
      values[0].push_back(bits % 50 == 0 ? std::nanf("") : v);
      values[1].push_back(-v);
      values[2].push_back(bits % 50 == 1 ? INFINITY : s.z_[i]);
      values[3].push_back(bits % 50 == 2 ? std::nanf("") : static_cast<float>(bits % 16));
    }
  }
  void put(Frame& frame, int i) const
  {
    for (std::size_t c = 0; c < kMaxChannels; c++)
      if ((i + static_cast<int>(c)) % 7) frame.channels[c] = values[c].data();
  }
  std::array<std::vector<float>, kMaxChannels> values;
};

/** Both give the same values of cells, and take the same. */
void hand_over_channels(Pair& maps)
{
  const Window w = maps.cpu.window();
  const std::vector<CellRect> rects{
      {w.min_cell_x + 3, w.min_cell_y, 50, 120}, {w.min_cell_x + 60, w.min_cell_y + 60, 90, 90}};
  const std::size_t size = rects[0].size() + rects[1].size();
  const ChannelRecord* const read = maps.cpu.read_channels(rects);
  ASSERT_EQ(std::memcmp(read, maps.cuda.read_channels(rects), size * sizeof(ChannelRecord)), 0);
  std::vector<ChannelRecord> records(read, read + size);
  std::reverse(records.begin(), records.end());
  maps.cpu.write_channels(rects, records.data(), size);
  maps.cuda.write_channels(rects, records.data(), size);
  maps.expect_same_bits();
}
}  // namespace

TEST(Parity, ChannelsOfADriveWithPointsInAnotherOrder)
{
  Parameters p;
  p.channels = channels_from("a:mean,b:latest,c:max,d:vote");
  p.channel_cost = channel_costs_from("d:3=0,7=0.5,11=0.25");
  Pair maps(p);
  Random noise(21), order(22);
  for (int i = 0; i < 32; i++)
  {
    Scan s = drive_frame(i, noise);
    if (i >= 25) s.pose_.m[11] += 5;  // another floor
    const Scan mixed = shuffled(s, order);
    const ChannelsOf values(s), other_values(mixed);
    Frame frame = s.frame(), other = mixed.frame();
    values.put(frame, i);
    other_values.put(other, i);
    ASSERT_NO_FATAL_FAILURE(maps.update(frame, other));
    if (i % 5 == 0) ASSERT_NO_FATAL_FAILURE(hand_over_channels(maps));
  }
}

TEST(Parity, ScansThatAreDeskewedAndNot)
{
  Pair maps;
  Random noise(5);
  for (int i = 0; i < 40; i++)
  {
    const Scan s = drive_frame(i, noise);
    std::vector<float> times(s.x_.size());
    for (std::size_t k = 0; k < times.size(); k++)
      times[k] = 0.1f * static_cast<float>(k) / static_cast<float>(times.size()) - 0.05f;
    if (!times.empty()) times[0] = std::nanf("");
    Frame f = s.frame(0.1 * i);
    if (i % 3)
    {
      f.time_s = times.data();
      Pose before = f.T_map_sensor, after = f.T_map_sensor;
      before.m[3] -= 0.05, after.m[3] += 0.05, after.m[7] += 0.02;
      f.path = {{-0.05, before}, {0.01, f.T_map_sensor}, {0.05, after}};
    }
    ASSERT_NO_FATAL_FAILURE(maps.update(f, f));
  }
}

TEST(Parity, FramesThatGrowAndShrinkOnAWideMapWithOutputLayers)
{
  Pair maps(with({{"window_m", 20.5}, {"feature_radius_m", 0.25}}));
  maps.cuda.set_output_layers({Layer::Traversability, Layer::Elevation, Layer::State});
  Random noise(6);
  for (int i = 0; i < 15; i++)
    ASSERT_NO_FATAL_FAILURE(
        maps.update(street_scan(-3 + 0.21 * i, 0.1 * i, 0.1 * i, 90 << (i % 5), 64, noise)));
}

TEST(Parity, AMapOfAMillionCellsWhoseLayersAreCopied)
{
  Pair maps(with({{"window_m", 50}}));
  maps.cuda.set_output_layers({Layer::Elevation, Layer::GroundElevation, Layer::Slope});
  Random noise(9);
  for (int i = 0; i < 2; i++)
    ASSERT_NO_FATAL_FAILURE(maps.update(street_scan(0.3 * i, 0, 0.1 * i, 720, 64, noise)));
}

TEST(Parity, TheWidestNeighbourhoodsOfObjectsAndFeaturesAndManySamples)
{
  for (const double window_m : {8.0, 18.05, 27.0})  // pooled too, few cells and many
  {
    Pair maps(with(
        {{"window_m", window_m},
         {"object_size_m", 3.2},
         {"feature_radius_m", 0.75},
         {"fill_samples", 5},
         {"fill_search_m", 6}}));
    Random noise(11);
    for (int i = 0; i < 3; i++)
      ASSERT_NO_FATAL_FAILURE(maps.update(street_scan(0.15 * i, 0, 0.1 * i, 360, 24, noise)));
  }
}

TEST(Parity, SmallWindowsJumpsAndOutputsThatChange)
{
  Pair maps(with({{"window_m", 2.55}}));
  Random noise(7);
  for (int i = 0; i < 40; i++)
  {
    Scan s(i % 10 == 9 ? 500.0 : 0.4 * i, i % 14 == 13 ? -1e5 : 0.0, 0.7);
    s.cast(street(0.1 * i), 180, -0.9, 0.1, 16);
    spoil(s, noise);
    ASSERT_NO_FATAL_FAILURE(maps.update(s));
    if (i == 10) maps.cuda.set_output_layers({Layer::GroundElevation, Layer::Slope});
    if (i == 20) maps.cuda.set_output_layers({});
    if (i == 30) maps.cuda.set_output_layers({Layer::Variance, Layer::Sparsity, Layer::Step});
    ASSERT_NO_FATAL_FAILURE(maps.expect_same_bits());
  }
}

TEST(Parity, CellsThatAreHandedOverWithFramesAndGivenBackOtherwise)
{
  constexpr std::size_t kBytes =
      offsetof(CellRecord, evidence) + CellRecord::kEvidenceBytes;  // without what pads it
  for (const double window_m : {8.0, 20.5})  // layers written directly, and copied
  {
    Pair maps(with({{"window_m", window_m}}));
    maps.cuda.set_output_layers({Layer::Elevation, Layer::State, Layer::Traversability});
    Random noise(17);
    for (int i = 0; i < 12; i++)
    {
      const Scan scan = street_scan(0.13 * i, -0.08 * i, 0.1 * i, 360, 32, noise);
      const Window now = maps.cpu.window(), next = maps.cpu.window_after(scan.frame());
      FrameCells cells[2];
      for (FrameCells& c : cells)
      {
        if (i > 0)
          c.before = {
              {now.min_cell_x, now.min_cell_y, 7, now.cells},
              {now.min_cell_x + 9, now.min_cell_y, now.cells - 9, 5}};
        c.after = {{next.min_cell_x + next.cells - 3, next.min_cell_y, 3, next.cells}};
      }
      maps.cpu.update(scan.frame(), cells[0]);
      maps.cuda.update(scan.frame(), cells[1]);
      for (const auto records : {&FrameCells::records_before, &FrameCells::records_after})
      {
        ASSERT_EQ((cells[0].*records).size, (cells[1].*records).size);
        for (std::size_t r = 0; r < (cells[0].*records).size; r++)
          ASSERT_EQ(std::memcmp(&(cells[0].*records)[r], &(cells[1].*records)[r], kBytes), 0);
      }
      for (FrameCells& c : cells)
        for (CellRecord& r : c.records_after) r.ground_m += 0.013f, r.traversability = 0.7f;
      maps.cpu.write_cells(cells[0].after, cells[0].records_after.first, cells[0].after[0].size());
      maps.cuda.write_cells(cells[1].after, cells[1].records_after.first, cells[1].after[0].size());
      ASSERT_NO_FATAL_FAILURE(maps.expect_same_bits());
    }
    const auto saved = maps.cuda.save();
    ASSERT_EQ(maps.cpu.save(), saved);
    maps.cuda.clear();
    maps.cuda.restore(saved);
    maps.cpu.restore(saved);
    ASSERT_NO_FATAL_FAILURE(maps.update(drive_frame(3, noise)));
  }
}
