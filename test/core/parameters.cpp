#include <gtest/gtest.h>
#include "scene.h"

#include <talus/elevation_mapper.h>
#include <talus/number_text.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

using namespace talus;
using namespace talus::test;

namespace
{
void expect_said(const Parameters& p, const std::string& what)
{
  EXPECT_TRUE(has(message_of([&] { p.validate(); }), what));
}
}  // namespace

TEST(Parameters, DefaultsAreThoseOfThePaperAndValid)
{
  const Parameters p;
  EXPECT_NO_THROW(p.validate());
  EXPECT_EQ(p.cells(), 160);
  EXPECT_EQ(p.slope_threshold_rad, 0.6);
  EXPECT_EQ(p.step_threshold_m, 0.2);
  EXPECT_EQ(p.roughness_threshold_m, 0.2);
}

TEST(Parameters, EveryEntryOfTheTableReadsBackWhatWasSetAndSetsNothingElse)
{
  for (const auto& info : parameter_table())
  {
    Parameters p;
    for (const double bad : {std::nan(""), -1e300, 1e300})
    {
      EXPECT_THROW(set_parameter(p, info, bad), std::invalid_argument) << info.name;
      EXPECT_TRUE(is_same_value(info, p, Parameters())) << info.name;
    }
    for (const double v : {info.min, info.max})
    {
      if (info.is_text()) break;
      set_parameter(p, info, v);
      EXPECT_EQ(info.get(p), v) << info.name;
    }
    Parameters q;
    set_parameter(q, info.name, parameter_text(Parameters(), info));
    EXPECT_TRUE(is_same_value(info, q, Parameters())) << info.name;
  }
}

TEST(Parameters, ValuesOutOfRangeAreNamedWithTheirRange)
{
  Parameters p;
  p.resolution_m = 0;
  expect_said(p, "resolution_m = 0");
  p.resolution_m = -0.05;
  expect_said(p, "must be a number from");
  p = {};
  p.weight_slope = 0.9;
  expect_said(p, "must be 1, not 1.5");
  p = {};
  p.voxel_m = 1e-5;
  EXPECT_NO_THROW(p.validate());
  p.max_range_m = 1e6;
  expect_said(p, "voxel_m = 1e-05 m is too small");
  p = {};
  p.window_m = 5000;
  expect_said(p, "100000 x 100000 cells");
  EXPECT_THROW(ElevationMapper{p}, std::invalid_argument);
  p = {};
  p.slope_threshold_rad = std::numeric_limits<double>::quiet_NaN();
  expect_said(p, "slope_threshold_rad = nan");
}

TEST(Parameters, TextIsParsedWholeOrRefused)
{
  Parameters p;
  set_parameter(p, "Fill_Samples", "7");
  EXPECT_EQ(p.fill_samples, 7);
  for (const char* bad : {"", "abc", "0.05m", "1e9", "nan"})
    EXPECT_THROW(set_parameter(p, "resolution_m", bad), std::invalid_argument) << bad;
  EXPECT_THROW(set_parameter(p, "cleanup_frames", "1.5"), std::invalid_argument);
  EXPECT_THROW(set_parameter(p, *find_parameter("fill_samples"), 1.5), std::invalid_argument);
}

TEST(Parameters, AnObjectSizeThatTheCellsCannotCountIsRefusedWithWhatIsPossible)
{
  Parameters p;
  for (const double m : {0.1, 0.11, 0.25, 0.99, 3.2, 3.25, 3.29})
  {
    p.object_size_m = m;
    EXPECT_NO_THROW(p.validate()) << m;
  }
  for (const double m : {0.05, 0.099, 3.31, 30.0})
  {
    p.object_size_m = m;
    expect_said(p, "object_size_m = " + number_text(m) + " m");
    expect_said(p, "from 0.1 to 3.25 m");
  }
  p.object_size_m = 0;
  expect_said(p, "object_size_m = 0 is out of range");
  p = {};
  p.resolution_m = 1;
  expect_said(p, "from 2 to 65 m");
}

TEST(Parameters, BoxesOfTheBodyAreReadFromTextAndBackToTheLastBit)
{
  const ParameterInfo& info = *find_parameter("body_boxes_m");
  Parameters p, q;
  EXPECT_EQ(parameter_text(p, info), "none");
  set_parameter(p, "body_boxes_m", "-0.5 0.5 -.3 0.3  0 1e0, 0.1 0.2 -1 1 0.30000000000000004 2");
  ASSERT_EQ(p.body_boxes_m.size(), 2u);
  EXPECT_EQ(p.body_boxes_m[0].min_y_m, -0.3);
  EXPECT_EQ(p.body_boxes_m[1].min_z_m, 0.1 + 0.2);
  EXPECT_EQ(parameter_text(p, info), "-0.5 0.5 -0.3 0.3 0 1, 0.1 0.2 -1 1 0.30000000000000004 2");
  EXPECT_FALSE(is_same_value(info, p, q));
  set_parameter(q, "body_boxes_m", parameter_text(p, info));
  EXPECT_TRUE(is_same_value(info, p, q));
  set_parameter(p, "body_boxes_m", "None");
  EXPECT_TRUE(p.body_boxes_m.empty());
  EXPECT_THROW(set_parameter(p, info, 1.0), std::invalid_argument);
}

TEST(Parameters, WhatIsNoBoxOfTheBodyIsRefusedWithAReason)
{
  const auto says = [](const std::string& text, const std::string& what)
  {
    Parameters p;
    EXPECT_TRUE(has(message_of([&] { set_parameter(p, "body_boxes_m", text); }), what)) << text;
    EXPECT_TRUE(p.body_boxes_m.empty());
  };
  for (const char* text :
       {"", "1 2 3", "0 1 0 1 0 1 0", "0 1 0 1 0 x", "0 1 0 1 0 1,", "0 1 0 1 0 1; 2 3 2 3 2 3"})
    says(text, "must be six numbers");
  says("0 1 0 0 0 1", "no extent in y");
  says("0 1 0 1 1 0", "no extent in z");
  says("0 1 0 1 0 nan", "must lie within");
  says("0 1 0 1 0 1e7", "must lie within");
  std::string many;
  for (int i = 0; i < 33; i++) many += (i ? ", " : "") + std::string("0 1 0 1 0 1");
  says(many, "33 boxes; 32 are supported");
  Parameters p;
  p.body_boxes_m = {{0, 1, 0, 1, 2, 1}};
  expect_said(p, "no extent in z");
}

TEST(Parameters, OnlyANameThatIsNearIsOffered)
{
  EXPECT_EQ(nearest_parameter_name("resolutoin_m"), "resolution_m");
  EXPECT_EQ(nearest_parameter_name("windo"), "window_m");
  EXPECT_EQ(nearest_parameter_name("clearence"), "clearance_m");
  EXPECT_EQ(nearest_parameter_name("min_variance"), "min_variance_m2");
  for (const char* far : {"foo", "", "x", "colour", "number_of_cells"})
    EXPECT_EQ(nearest_parameter_name(far), "") << far;
  Parameters p;
  const std::string said = message_of([&] { set_parameter(p, "foo", "1"); });
  EXPECT_TRUE(has(said, "'foo'"));
  EXPECT_FALSE(has(said, "did you mean"));
}

TEST(NumberText, is_what_people_and_programs_write)
{
  for (const auto& [text, value] : std::vector<std::pair<const char*, double>>{
           {"0.10", 0.1}, {"+2", 2}, {"-.5", -0.5}, {"5.", 5}, {"1e-3", 1e-3}, {" 7", 7}, {"0", 0}})
    EXPECT_EQ(number_from(text), value) << text;
  for (const char* none :
       {"", " ", "+", "-", "+-1", "++1", "0,1", "1 ", "1e", "1m", "0x10", "1e999", "."})
    EXPECT_EQ(number_from(none), std::nullopt) << none;
  EXPECT_TRUE(std::isinf(number_from("-inf").value()));
  EXPECT_EQ(number_text(1.0 / 3), "0.3333333333");
  EXPECT_EQ(number_text(1e-7, 3), "1e-07");
  EXPECT_EQ(number_text(-1.7976931348623157e308, 17), "-1.7976931348623157e+308");
  EXPECT_EQ(fixed_text(-1.7976931348623157e308, 3).size(), 314U);
  EXPECT_EQ(fixed_text(0.125, 2), "0.12");
  EXPECT_EQ(fixed_text(std::nan(""), 2), "nan");
}
