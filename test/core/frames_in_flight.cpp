#include <gtest/gtest.h>
#include "scene.h"

#include <algorithm>
#include <deque>

using namespace talus;
using namespace talus::test;

// start() and finish() with two frames in flight leave what update() leaves.

namespace
{
const std::vector<Layer> kTwo{Layer::Traversability, Layer::Elevation};
const std::vector<Layer> kMany{
    Layer::GroundElevation, Layer::Variance, Layer::State, Layer::Slope, Layer::Traversability};

/** Frames of several sizes past boxes and a walker; some are empty. */
Scan scan_at(int i)
{
  const double w = 0.05 * i;
  Scan s(0.11 * i, 0.02 * i, 0.7);
  if (i % 7 == 3) return s;
  const std::vector<Box> boxes{
      {{2, 0.5, 0}, {2.3, 0.9, 0.5}},
      {{4, -1, 0.75}, {4.6, 1, 0.8}},
      {{3 - w, 1.2, 0}, {3.4 - w, 1.5, 1.4}}};
  return s.cast(boxes, 45 << (i % 5), -0.6, 0.1, 24);
}

/** A map that is fed frame by frame, and one with two in flight. */
class Both
{
 public:
  Both(const Parameters& p, const std::vector<Layer>& layers)
      : one_by_one(p, tested_backend()), overlapped(p, tested_backend())
  {
    set_output_layers(layers);
  }
  void set_output_layers(const std::vector<Layer>& layers)
  {
    layers_ = layers;
    one_by_one.set_output_layers(layers);
    overlapped.set_output_layers(layers);
  }

  /** Starts a frame on its way and finishes the one before. */
  void feed(const Scan& scan, bool in_place = false)
  {
    started_.push_back(scan);
    Frame frame = started_.back().frame(0.1 * frames_++);
    if (in_place) put_in_place(frame);
    overlapped.start(frame);
    if (overlapped.frames_in_flight() == 2) finish();
  }
  void finish()
  {
    const Scan& scan = started_.front();
    const FrameReport a = one_by_one.update(scan.frame(0.1 * finished_++));
    const FrameReport b = overlapped.finish();
    ASSERT_EQ(a.stamp_s, b.stamp_s);
    ASSERT_EQ(a.points_in, b.points_in);
    ASSERT_EQ(a.points_accepted, b.points_accepted);
    ASSERT_EQ(a.rejected, b.rejected);
    ASSERT_EQ(one_by_one.window().min_cell_x, overlapped.window().min_cell_x);
    for (const Layer l : layers_)
      ASSERT_TRUE(same_bits(one_by_one.layer(l), overlapped.layer(l))) << layer_name(l);
    // What was finished is not looked at any longer.
    for (auto* values : {&started_.front().x_, &started_.front().y_, &started_.front().z_})
      std::fill(values->begin(), values->end(), 1.0f);
    started_.pop_front();
  }
  void finish_all()
  {
    while (overlapped.frames_in_flight()) ASSERT_NO_FATAL_FAILURE(finish());
    expect_same_bits(one_by_one, overlapped, frames_);
    ASSERT_EQ(one_by_one.save(), overlapped.save());
  }

  ElevationMapper one_by_one, overlapped;

 private:
  void put_in_place(Frame& frame)
  {
    const PointArrays to = overlapped.point_arrays(frame.size);
    std::copy_n(frame.x_m, frame.size, to.x_m);
    std::copy_n(frame.y_m, frame.size, to.y_m);
    std::copy_n(frame.z_m, frame.size, to.z_m);
    frame.x_m = to.x_m, frame.y_m = to.y_m, frame.z_m = to.z_m;
  }

  std::vector<Layer> layers_;
  std::deque<Scan> started_;
  int frames_ = 0, finished_ = 0;
};

Parameters window(double side_m) { return with({{"window_m", side_m}}); }
}  // namespace

TEST(FramesInFlight, LeaveTheBitsOfFramesOneByOne)
{
  for (const auto& layers : {kTwo, kMany, std::vector<Layer>{}})
  {
    Both maps(window(8), layers);
    for (int i = 0; i < 15; i++) ASSERT_NO_FATAL_FAILURE(maps.feed(scan_at(i)));
    ASSERT_NO_FATAL_FAILURE(maps.finish_all());
  }
}

TEST(FramesInFlight, AlsoOnWideMapsWhoseLayersAreCopiedAndOfLargeScansVoxelsAndPointsInPlace)
{
  Parameters voxels = window(6);
  voxels.voxel_m = 0.1;
  Both wide(window(18.5), kTwo), wide_with_many(window(18.5), kMany), filtered(voxels, kTwo);
  for (int i = 0; i < 20; i++)
  {
    ASSERT_NO_FATAL_FAILURE(filtered.feed(scan_at(i), i % 3 != 0));
    if (i >= 8) continue;
    const Scan s = Scan(0.1 * i, 0)
                       .cast({{{2, 0.5, 0}, {2.3, 0.9, 0.5}}}, 1800 + 360 * (i % 3), -0.6, 0.1, 40);
    ASSERT_NO_FATAL_FAILURE(wide.feed(s, i % 2 == 1));
    if (i < 4) ASSERT_NO_FATAL_FAILURE(wide_with_many.feed(scan_at(i)));
  }
  for (Both* maps : {&wide, &wide_with_many, &filtered})
    ASSERT_NO_FATAL_FAILURE(maps->finish_all());
}

TEST(FramesInFlight, MayStopAndGoOnAndMixWithUpdates)
{
  Both maps(window(8), kMany);
  for (int i = 0; i < 24; i++)
  {
    ASSERT_NO_FATAL_FAILURE(maps.feed(scan_at(i)));
    if (i % 5 != 4) continue;
    ASSERT_NO_FATAL_FAILURE(maps.finish_all());
    const Scan s = scan_at(i + 1);
    maps.one_by_one.update(s.frame());
    maps.overlapped.update(s.frame());
    if (i == 9) maps.overlapped.restore(maps.one_by_one.save());
    if (i == 14) maps.one_by_one.clear(), maps.overlapped.clear();
    if (i == 19) maps.set_output_layers(kTwo);
  }
  ASSERT_NO_FATAL_FAILURE(maps.finish_all());
}

TEST(FramesInFlight, RoomForTheNextPointsDoesNotChangeWhatIsShown)
{
  for (const auto& layers : {kTwo, kMany})
  {
    Both maps(window(6), layers);
    for (int i = 0; i < 4; i++) ASSERT_NO_FATAL_FAILURE(maps.feed(scan_at(i)));
    ASSERT_NO_FATAL_FAILURE(maps.finish());
    maps.overlapped.point_arrays(5000);
    ASSERT_NO_FATAL_FAILURE(maps.finish_all());
    Scan bad;
    bad.pose_.m[3] = NAN;
    EXPECT_THROW(maps.overlapped.start(bad.frame()), std::invalid_argument);
    ASSERT_NO_FATAL_FAILURE(maps.finish_all());
  }
}

TEST(FramesInFlight, WhatNoFrameMayHaveThrowsAtTheStartAndChangesNothing)
{
  Both maps(window(8), kTwo);
  ASSERT_NO_FATAL_FAILURE(maps.feed(scan_at(0)));
  const Scan scan = scan_at(1);
  const Frame good = scan.frame();
  std::vector<Frame> bad(14, good);
  bad[0].size = 536870912;
  bad[1].T_map_sensor.m[7] = -1.01e9 * maps.overlapped.parameters().resolution_m;
  const TimedPose start{0, good.T_map_sensor}, end{0.1, good.T_map_sensor};
  bad[2].path = {start, end};
  bad[2].path[1].T_map_sensor.m[3] = 1.01e9 * maps.overlapped.parameters().resolution_m;
  bad[3].path = {start, end};
  bad[3].path[0].T_map_sensor.m[0] = NAN;
  bad[4].path = {end, start};
  bad[5].path = {start, {0.2, good.T_map_sensor}, end};
  bad[6].path = {start, {NAN, good.T_map_sensor}, end};
  bad[7].path = {start, {INFINITY, good.T_map_sensor}};
  bad[8].y_m = nullptr;
  bad[9].T_map_sensor.m[11] = -1.01e5;
  bad[10].T_map_sensor.m[0] = 1.1;
  bad[11].T_map_sensor.m[10] = -1;  // mirrored
  bad[12].path = {start, end};
  bad[12].path[1].T_map_sensor.m = {};
  bad[13].T_map_sensor.m[3] = NAN;
  for (std::size_t i = 0; i < bad.size(); i++)
  {
    EXPECT_THROW(maps.overlapped.start(bad[i]), std::invalid_argument) << i;
    EXPECT_EQ(maps.overlapped.frames_in_flight(), 1) << i;
  }
  ASSERT_NO_FATAL_FAILURE(maps.feed(scan));
  ASSERT_NO_FATAL_FAILURE(maps.finish_all());
}

TEST(FramesInFlight, WhatCannotBeDoneMeanwhileSaysWhatToDo)
{
  TestMap m(window(4));
  ElevationMapper& map = m.map;
  map.set_output_layers(kTwo);
  EXPECT_TRUE(has(message_of([&] { map.finish(); }), "start()"));
  const Scan a = scan_at(0), b = scan_at(1);
  const auto saved = map.save();
  map.start(a.frame());
  EXPECT_TRUE(map.empty());
  for (const std::string& message :
       {message_of([&] { map.update(b.frame()); }), message_of([&] { map.save(); }),
        message_of([&] { map.restore(saved); }), message_of([&] { map.clear(); }),
        message_of([&] { map.set_output_layers({}); }),
        message_of([&] { map.layer(Layer::State); })})
    EXPECT_TRUE(has(message, "finish"));
  map.start(b.frame());
  EXPECT_TRUE(has(message_of([&] { map.start(a.frame()); }), "two frames"));
  EXPECT_TRUE(has(message_of([&] { map.point_arrays(9); }), "two frames"));
  EXPECT_EQ(map.frames_in_flight(), 2);
  map.finish();
  EXPECT_TRUE(has(message_of([&] { map.layer(Layer::State); }), "state"));
  EXPECT_EQ(map.layer(Layer::Elevation).size(), 80u * 80u);
  map.start(a.frame());
  EXPECT_THROW(map.layer(Layer::Elevation), std::logic_error) << "its memory is written again";
  map.finish();
  map.finish();
  EXPECT_EQ(map.layer(Layer::State).size(), 80u * 80u);
}

TEST(FramesInFlight, AMapMayGoWhileTheyAre)
{
  const Scan a = scan_at(0), b = scan_at(1);
  for (const double side_m : {4.0, 30.0})
  {
    TestMap m(window(side_m));
    m.map.set_output_layers(kMany);
    m.map.start(a.frame());
    m.map.start(b.frame());
    ElevationMapper moved = std::move(m.map);
    EXPECT_EQ(moved.frames_in_flight(), 2);
  }
}
