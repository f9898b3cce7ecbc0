#include <gtest/gtest.h>
#include "scene.h"

#include <talus/frame_gatherer.h>
#include <talus/map_view.h>
#include <talus/point_labels.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

using namespace talus;
using namespace talus::test;

namespace
{
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/** A scan whose points bring values. */
struct ValuedScan
{
  using Value = std::function<float(double x, double y, double z)>;

  /** value(x, y, z) of the map frame gives that of each point. */
  ValuedScan(const Scan& s, const Value& value) : scan(s)
  {
    for (std::size_t i = 0; i < s.x_.size(); i++)
      values.push_back(value(s.x_[i] + s.pose_.x(), s.y_[i] + s.pose_.y(), s.z_[i] + s.pose_.z()));
  }
  ValuedScan(const Scan& s, float value)
      : ValuedScan(s, [value](double, double, double) { return value; })
  {
  }
  Frame frame(double stamp_s = 0) const
  {
    Frame f = scan.frame(stamp_s);
    f.channels[0] = values.data();
    return f;
  }

  Scan scan;
  std::vector<float> values;
};

Parameters with(const std::string& channels, double window_m = 8)
{
  Parameters p;
  p.channels = channels_from(channels);
  p.window_m = window_m;
  return p;
}
/** The one value up to a height of 0.2 m, the other above. */
ValuedScan::Value by_height(float low, float high)
{
  return [=](double, double, double z) { return z < 0.2 ? low : high; };
}

/** A map with the channel `v`. */
struct ChannelMap : TestMap
{
  explicit ChannelMap(const std::string& rule, int threads = 1, double window_m = 8)
      : TestMap(with("v:" + rule, window_m), threads)
  {
  }
  void see(const Scan& scan, const ValuedScan::Value& value)
  {
    map.update(ValuedScan(scan, value).frame());
  }
  void see(const Scan& scan, float value) { map.update(ValuedScan(scan, value).frame()); }
  float ground(double x = 1.22, double y = 1.22) const { return MapView(map).at("v", x, y); }
  float standing(double x = 1.22, double y = 1.22) const
  {
    return MapView(map).at("v_standing", x, y);
  }
};

const Scan kFloor = Scan().add_surface(-3, -3, 3, 3, flat);
const Scan kPatch = Scan().add_surface(0, 0, 0.3, 0.3, flat);  //!< for many frames, with kSmall_m
constexpr double kSmall_m = 1;
const Scan kFloorAndBox = Scan(kFloor).add_surface(1, 1, 1.5, 1.5, level(0.4));

template <class Call>
void expect_invalid(const Call& call, const std::string& word)
{
  EXPECT_TRUE(has(message_of(call), word));
}
}  // namespace

TEST(Channels, GroundAndWhatStandsOnItHaveTheirOwn)
{
  ChannelMap m("mean");
  m.see(kFloorAndBox, by_height(10, 50.5F));
  EXPECT_EQ(m.ground(), 10);
  EXPECT_EQ(m.standing(), 50.5F);
  EXPECT_EQ(m.ground(-1, -1), 10);
  EXPECT_TRUE(std::isnan(m.standing(-1, -1))) << "nothing stands there";
  EXPECT_TRUE(std::isnan(m.ground(3.9, 3.9))) << "not seen";
}

TEST(Channels, OfCellsAreReadAndWrittenWhereNothingIsKnown)
{
  for (const std::string rule : {"mean", "vote", "max", "latest"})
  {
    ChannelMap from(rule), to(rule);
    from.see(kFloorAndBox, by_height(10, 5));
    to.map.update(kFloorAndBox.frame());  // without values
    const Window w = from.map.window();
    const std::vector<CellRect> rects{
        {w.min_cell_x + 90, w.min_cell_y + 90, 30, 20}, {w.min_cell_x, w.min_cell_y, 90, 90}};
    const std::size_t size = rects[0].size() + rects[1].size();
    const ChannelRecord* const read = from.map.read_channels(rects);
    const std::vector<ChannelRecord> records(read, read + size);
    EXPECT_TRUE(std::isnan(to.ground()));
    to.map.write_channels(rects, records.data(), size);
    EXPECT_EQ(to.ground(), 10) << rule;
    EXPECT_EQ(to.standing(), 5) << rule;
    EXPECT_EQ(to.ground(-1, -1), 10);
    EXPECT_TRUE(std::isnan(to.standing(-1, -1)));
    EXPECT_TRUE(std::isnan(to.ground(2.5, 2.5))) << "in none of the rectangles";
    to.see(kFloorAndBox, 3);
    EXPECT_EQ(to.ground(2.5, 2.5), 3);
    const float now = to.ground();
    to.map.write_channels(rects, records.data(), size);
    EXPECT_EQ(to.ground(), now) << "what the map knows stays";
  }
}

TEST(Channels, WhatHangsOrMovedAwayCountsForNeither)
{
  ChannelMap m("mean");
  const Scan scan = Scan(kFloor).add_surface(1, -1, 2, 1, level(1.5));
  m.see(scan, by_height(10, 90));
  EXPECT_EQ(m.ground(1.22, 0.02), 10);
  EXPECT_TRUE(std::isnan(m.standing(1.22, 0.02)));
}

TEST(Channels, PointsGoWhereTheirLabelsSay)
{
  ChannelMap m("max"), labelled("mean");
  for (int i = 0; i < 3; i++)
  {
    const Scan scan =
        Scan(0.1 * i, 0).cast({{{1.5, -0.4, 0}, {2, 0.4, 0.8}}, {{-3, -2, 0}, {-1.2, 2, 0.5}}});
    labelled.update(scan);
    Frame frame = scan.frame();
    std::vector<float> labels;
    for (const PointLabel l : label_points(labelled.map, frame))
      labels.push_back(static_cast<float>(l));
    frame.channels[0] = labels.data();
    m.map.update(frame);
  }
  const auto count = [&](const char* layer, PointLabel label)
  {
    int known = 0;
    for (const float v : m.map.channel(layer))
    {
      known += !std::isnan(v);
      EXPECT_TRUE(std::isnan(v) || v == static_cast<float>(label)) << layer;
    }
    return known;
  };
  EXPECT_GT(count("v", PointLabel::Ground), 1000);
  EXPECT_GT(count("v_standing", PointLabel::Stands), 10);
}

TEST(Channels, AMeanIsOfAllPointsAndFollowsChange)
{
  ChannelMap m("mean", 1, kSmall_m);
  m.see(Scan(kPatch).add_surface(0, 0, 0.3, 0.3, flat), 1);
  m.see(kPatch, 4);
  EXPECT_EQ(m.ground(0.12, 0.12), 2);
  for (int i = 0; i < 150; i++) m.see(kPatch, 8);
  EXPECT_GT(m.ground(0.12, 0.12), 7.5F) << "64 points count";
  for (int i = 0; i < 64; i++) m.see(kPatch, -8);
  EXPECT_LT(m.ground(0.12, 0.12), -1);
  for (const float v : {0.001F, 0.5F, -1234.25F, 65535.0F, 16777216.0F})
  {
    m.map.clear();
    m.see(kPatch, v);
    EXPECT_NEAR(m.ground(0.12, 0.12), v, 1.0 / 65536);
  }
}

TEST(Channels, TheLatestIsTheMeanOfTheLastFrameThatSawIt)
{
  ChannelMap m("latest");
  m.see(kFloor, 100);
  m.see(Scan(kFloor).add_surface(-3, -3, 0, 3, flat), 3);
  EXPECT_EQ(m.ground(), 3);
  Scan twice = Scan().add_surface(-3, -3, 0, 3, flat).add_surface(-3, -3, 0, 3, flat);
  ValuedScan scan(twice, 5);
  for (std::size_t i = 0; i < scan.values.size() / 2; i++) scan.values[i] = 8;
  m.map.update(scan.frame());
  EXPECT_EQ(m.ground(-1.02, 1.02), 6.5F);
  EXPECT_EQ(m.ground(), 3);
}

TEST(Channels, TheClassOfMostPointsWinsAndCanLose)
{
  ChannelMap m("vote", 1, kSmall_m);
  for (const int c : {3, 15, 15, 0}) m.see(kPatch, static_cast<float>(c));
  EXPECT_EQ(m.ground(0.12, 0.12), 15);
  m.see(kPatch, 3);
  EXPECT_EQ(m.ground(0.12, 0.12), 3) << "of two with as many the first";
  for (int i = 0; i < 150; i++) m.see(kPatch, 7);
  EXPECT_EQ(m.ground(0.12, 0.12), 7);
  for (int i = 0; i < 66; i++) m.see(kPatch, 2);
  EXPECT_EQ(m.ground(0.12, 0.12), 2) << "the past has 64 votes";
  Scan many;
  for (int i = 0; i < 5000; i++) many.add(0.12, 0.12, 0);
  m.see(many, 4);
  for (int i = 0; i < 66; i++) m.see(kPatch, 9);
  EXPECT_EQ(m.ground(0.12, 0.12), 9) << "also of a scan with thousands of points in a cell";
}

TEST(Channels, ValuesThatAreNoneCountForNothing)
{
  for (const char* rule : {"mean", "latest", "max", "vote"})
  {
    ChannelMap m(rule);
    m.see(kFloor, kNan);
    EXPECT_TRUE(std::isnan(m.ground())) << rule;
    m.see(kFloor, 2);
    m.see(kFloor, kNan);
    m.update(kFloor);  // without values
    EXPECT_EQ(m.ground(), 2) << rule;
    if (rule == std::string("vote")) continue;
    m.see(kFloor, INFINITY);
    m.see(kFloor, -1e30F);
    EXPECT_EQ(m.ground(), 2) << rule;
  }
}

TEST(Channels, WhatLeftTakesItsChannelAlong)
{
  ChannelMap m("vote");
  const Scan with_box = Scan().cast({{{1.5, -0.4, 0}, {2, 0.4, 0.8}}});
  for (int i = 0; i < 8; i++) m.see(with_box, by_height(1, 5));
  EXPECT_EQ(m.standing(1.52, 0.02), 5);
  for (int i = 0; i < 6; i++) m.see(Scan().cast({}), by_height(1, 5));
  EXPECT_TRUE(std::isnan(m.standing(1.52, 0.02)));
  EXPECT_EQ(m.ground(1.52, 0.02), 1);
  m.see(with_box, by_height(1, 6));
  EXPECT_EQ(m.standing(1.52, 0.02), 6) << "what stands there now is another";
}

TEST(Channels, RollWithTheWindowOnBothSidesOfTheOrigin)
{
  ChannelMap m("mean");
  for (const double x : {0.0, -5.03, 7.21})
    m.see(
        Scan(x, -x).add_surface(x - 3, -x - 3, x + 3, -x + 3, flat),
        [](double px, double, double) { return static_cast<float>(std::floor(px)); });
  EXPECT_EQ(m.ground(5.52, -7.02), 5);
  EXPECT_EQ(m.ground(9.02, -7.02), 9);
  m.see(Scan(2, -2), 0);
  EXPECT_EQ(m.ground(5.02, -5.02), 5) << "it stayed in the window";
  m.see(Scan(-60, 0), 0);
  m.see(Scan(2, -2), 0);
  EXPECT_TRUE(std::isnan(m.ground(5.02, -5.02))) << "it left";
  m.see(Scan(2, -2).add(5.02, -5.02, 0), 3);
  EXPECT_EQ(m.ground(5.02, -5.02), 3);
  for (int i = 0; i < 9; i++) m.see(kFloor, 4);
  m.map.clear();
  m.see(kFloor, 2);
  EXPECT_EQ(m.ground(), 2);
}

TEST(Channels, AreNotInASavedMapAndStayWhenOutputsAreSet)
{
  ChannelMap m("vote"), restored("vote");
  m.see(kFloorAndBox, 4);
  TestMap plain(kFloorAndBox);
  EXPECT_EQ(m.map.save(), plain.map.save());
  restored.map.restore(m.map.save());
  EXPECT_TRUE(std::isnan(restored.ground()));
  m.map.set_output_layers({Layer::Elevation});
  EXPECT_EQ(m.ground(), 4);
  m.see(kFloor, 5);
  m.see(kFloor, 4);
  EXPECT_EQ(m.ground(), 4) << "the votes stayed, too";
}

TEST(Channels, HaveTheSameBitsInAnyOrderOfPointsAndWithAnyThreads)
{
  const auto value = [](double x, double y, double z)
  { return static_cast<float>(std::sin(40 * x) + 1e3 * y * y - 7 * z); };
  ChannelMap one("mean"), other("mean", 2);
  for (int i = 0; i < 5; i++)
  {
    const Scan scan = Scan(0.07 * i, 0).cast({{{1.5, -0.4, 0}, {2, 0.4, 0.8}}});
    Scan mirrored = scan;
    for (auto* a : {&mirrored.x_, &mirrored.y_, &mirrored.z_}) std::reverse(a->begin(), a->end());
    one.see(scan, value);
    other.see(mirrored, value);
  }
  for (const char* name : {"v", "v_standing"})
    EXPECT_TRUE(same_bits(one.map.channel(name), other.map.channel(name))) << name;
}

TEST(Channels, EachOfSeveralHasItsRule)
{
  TestMap m(with("a:mean,b:latest,c:max,d:vote"));
  const std::vector<std::vector<float>> values{{1, 2, 6}, {5, 9, 7}, {-7.5F, -2, -3}, {5, 9, 9}};
  for (std::size_t i = 0; i < 3; i++)
  {
    std::vector<std::vector<float>> of_points;
    Frame f = kFloor.frame();
    for (const auto& v : values) of_points.emplace_back(f.size, v[i]);
    for (std::size_t c = 0; c < 4; c++) f.channels[c] = of_points[c].data();
    m.map.update(f);
  }
  const MapView view(m.map);
  EXPECT_EQ(view.at("a", 1, 1), 3);
  EXPECT_EQ(view.at("b", 1, 1), 7);
  EXPECT_EQ(view.at("c", 1, 1), -2);
  EXPECT_EQ(view.at("d", 1, 1), 9);
}

TEST(Channels, OfTwoFramesInFlightAreThoseOfTheFrames)
{
  ChannelMap m("mean");
  std::vector<ValuedScan> scans;
  for (int i = 0; i < 4; i++)
    scans.emplace_back(Scan().add_surface(-3, -3, i - 1, 3, flat), static_cast<float>(1 << i));
  m.map.start(scans[0].frame());
  for (int i = 1; i < 4; i++)
  {
    m.map.start(scans[static_cast<std::size_t>(i)].frame());
    EXPECT_THROW(m.map.channel("v"), std::logic_error);
    m.map.finish();
  }
  m.map.finish();
  EXPECT_EQ(m.ground(-2, 1), 3.75F);
  EXPECT_EQ(m.ground(1.5, 1), 8);
}

TEST(Channels, OfScansInPartsAreGathered)
{
  FrameGatherer gatherer;
  ChannelMap m("mean");
  int scans = 0;
  const auto take = [&](const Frame& scan)
  {
    scans++;
    m.map.update(scan);
  };
  const ValuedScan valued(kFloor, 6);
  for (int i = 0; i < 24; i++)
  {
    Frame f = valued.frame(100 + 0.01 * i);
    if (i % 2) f.channels = {};
    gatherer.add(f, take);
  }
  gatherer.finish(take);
  EXPECT_LT(scans, 6);
  EXPECT_EQ(m.ground(), 6);
}

/** A map with a second channel `v` whose classes cost. */
struct CostMap : TestMap
{
  explicit CostMap(const Parameters& p = parameters()) : TestMap(p, 1) {}
  void see(const ValuedScan& scan)
  {
    Frame f = scan.frame();
    std::swap(f.channels[0], f.channels[1]);
    map.update(f);
  }
  static Parameters parameters()
  {
    Parameters p = with("other:mean,v:vote");
    p.channel_cost = channel_costs_from("v:3=0,7=0.5,9=1");
    return p;
  }
};

TEST(Channels, TraversabilityIsTheLeastOfTheScoreAndThoseOfTheClasses)
{
  CostMap m;
  const auto class_at = [](double x, double y, double z) {
    return z > 0.2 ? 3.0F : x < 0 ? (y < 0 ? 3.0F : 7.0F) : y < 0 ? 9.0F : 1.0F;
  };
  m.see(ValuedScan(kFloorAndBox, class_at));
  const TestMap free(kFloorAndBox);
  EXPECT_EQ(m.traversability(-1.02, -1.02), 0);
  EXPECT_EQ(m.traversability(-1.02, 1.02), 0.5F);
  for (const double x : {0.72, 1.02, 2.02})
    for (const double y : {-1.02, 0.72})
      EXPECT_EQ(m.traversability(x, y), free.traversability(x, y)) << x << " " << y;
  EXPECT_EQ(m.traversability(1.22, 1.22), 0) << "the box";
  EXPECT_TRUE(std::isnan(m.traversability(3.9, 3.9))) << "what is not judged stays so";
  Parameters unfilled = CostMap::parameters();
  unfilled.fill_search_m = 0;
  CostMap lone(unfilled);
  lone.see(ValuedScan(Scan().add(2.02, 1.02, 0), 3.0F));
  ASSERT_EQ(MapView(lone.map).at("v", 2.02, 1.02), 3.0F);
  EXPECT_TRUE(std::isnan(lone.traversability(2.02, 1.02))) << "also where the class costs";
  for (int i = 0; i < 3; i++) m.see(ValuedScan(kFloorAndBox, 1.0F));
  EXPECT_EQ(m.traversability(-1.02, -1.02), free.traversability(-1.02, -1.02))
      << "its class has changed";
}

TEST(Channels, WhatStandsCostsByItsOwnClass)
{
  CostMap m;
  const Scan low = Scan(kFloor).add_surface(1, 1, 2, 2, level(0.12));
  m.see(ValuedScan(low, [](double, double, double z) { return z > 0.1 ? 3.0F : 1.0F; }));
  ASSERT_TRUE(std::isnan(MapView(m.map).at("v_standing", -1, -1)));
  const bool stands = !std::isnan(MapView(m.map).at("v_standing", 1.52, 1.52));
  EXPECT_EQ(m.traversability(1.52, 1.52), 0) << (stands ? "on the ground" : "the ground itself");
  EXPECT_GT(m.traversability(-1, -1), 0.9F);
}

TEST(Channels, CostsShowInAllOutputsAndInRecords)
{
  CostMap m;
  m.map.set_output_layers({Layer::Elevation, Layer::Traversability, Layer::Slope});
  m.see(ValuedScan(kFloor, 7.0F));
  EXPECT_EQ(m.traversability(1, 1), 0.5F);
  EXPECT_EQ(MapView(m.map).at(Layer::Slope, 1, 1), 1) << "its parts stay as they are";
  EXPECT_EQ(MapView(m.map).at(Layer::Step, 1, 1), 1);
  EXPECT_EQ(m.traversability(1, 1), 0.5F);
  const Window w = m.map.window();
  const auto cells = m.map.read_cells({{w.min_cell_x + w.cells / 2, w.min_cell_y + 90, 1, 1}});
  EXPECT_EQ(cells[0].traversability, 0.5F);
}

TEST(Channels, CostsAreReadAsTextAndCheckedByName)
{
  const auto costs = channel_costs_from("label:3=0,7=0.5, sort:0=0.25");
  ASSERT_EQ(costs.size(), 3U);
  EXPECT_EQ(channel_costs_text(costs), "label:3=0,label:7=0.5,sort:0=0.25");
  EXPECT_TRUE(channel_costs_from("none").empty());
  EXPECT_EQ(channel_costs_text({}), "none");
  const auto channels = channels_from("label:vote,sort:mean");
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {"label", "must be NAME:CLASS=SCORE"},
           {"3=0", "names no channel"},
           {"label:3=0,", "must be NAME:CLASS=SCORE"},
           {"label:x=0", "a class is"},
           {"label:2.5=0", "a class is"},
           {"label:=0", "a class is"},
           {"label:16=0", "a class is"},
           {"label:-1=0", "a class is"},
           {"label:1=", "a score is"},
           {"label:1=nan", "a score is"},
           {"label:1=-0.5", "a score is"},
           {"label:1=0,1=1", "given twice"},
           {"sort:1=0", "only a vote"},
           {"other:1=0", "no channel 'other'"}})
    expect_invalid(
        [&, t = text] { validate_channel_costs(channel_costs_from(t), channels); }, word);
}

TEST(Channels, ALiveMapPublishesThem)
{
  LiveMap map(with("v:mean"), {Layer::Elevation}, tested_backend());
  map.ingest(ValuedScan(kFloor, 6).frame(100));
  const auto snapshot = map.snapshot();
  ASSERT_TRUE(snapshot);
  EXPECT_EQ(MapView(*snapshot).at("v", 1, 1), 6);
  EXPECT_TRUE(std::isnan(MapView(*snapshot).at("v_standing", 1, 1)));
  expect_invalid([&] { snapshot->channel("w"); }, "'w'");
}

TEST(Channels, AreReadAsTextAndCheckedByName)
{
  const auto channels = channels_from("intensity:mean,label:vote");
  ASSERT_EQ(channels.size(), 2U);
  EXPECT_EQ(channels[1].rule, ChannelRule::Vote);
  EXPECT_EQ(channels_text(channels), "intensity:mean,label:vote");
  EXPECT_EQ(
      channel_layer_names(channels),
      (std::vector<std::string>{"intensity", "intensity_standing", "label", "label_standing"}));
  EXPECT_TRUE(channels_from("none").empty());
  EXPECT_EQ(channels_text({}), "none");
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {"a:mean,b:mean,c:mean,d:mean,e:mean", "5 of them"},
           {"a:mean,a:vote", "two of them are called 'a'"},
           {"intensity", "has no rule"},
           {"intensity:median", "'median'"},
           {":mean", "is no name"},
           {"Intensity:mean", "is no name"},
           {"a:mean,", "has no rule"},
           {"slope:mean", "name of a layer"},
           {"age:mean", "name of a layer"},
           {"a_standing:mean", "name of a layer"}})
    expect_invalid([&, t = text] { channels_from(t); }, word);
}

TEST(Channels, OfAFrameMustBeThoseOfTheMap)
{
  TestMap plain;
  ChannelMap votes("vote");
  expect_invalid([&] { plain.map.update(ValuedScan(kFloor, 1).frame()); }, "the map has 0");
  expect_invalid([&] { plain.map.channel("v"); }, "'v'");
  plain.update(kFloor);
  const Window w = plain.map.window();
  const std::vector<CellRect> rects{{w.min_cell_x, w.min_cell_y, 3, 3}};
  const ChannelRecord one;
  EXPECT_EQ(plain.map.read_channels(rects), nullptr);
  EXPECT_THROW(plain.map.write_channels(rects, &one, 1), std::invalid_argument);
  for (const float v : {16.0F, -1.0F, 2.5F, INFINITY})
    expect_invalid([&] { votes.see(kFloor, v); }, "'v' has the value");
  EXPECT_TRUE(votes.map.empty()) << "nothing has changed";
  Parameters p = with("v:vote");
  p.channels.push_back(p.channels[0]);
  expect_invalid([&] { TestMap(p, 1); }, "two of them");
}
