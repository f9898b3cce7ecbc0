#include <gtest/gtest.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/exceptions.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/mrpt/version_compat.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "message_of.h"

using mrpt::config::CConfigFileMemory;
using talus::Parameters;

namespace
{
std::vector<std::string> load(const std::string& text, Parameters& p)
{
  return talus::load_parameters(CConfigFileMemory(text), "Map", p);
}

std::string error_of(const std::string& text)
{
  Parameters p;
  return message_of([&] { load(text, p); });
}

/** What require_sound_ini() finds in the sections Map_a and Map_b. */
std::string flaw_of(const std::string& text)
{
  return message_of([&] { talus::require_sound_ini(text, "f.ini", {"Map_a", "Map_b"}); });
}
}  // namespace

TEST(ParametersIni, every_parameter_is_accepted_in_either_section)
{
  Parameters p;
  const auto warnings = load(
      "[Map_creationOpts]\nresolution = 0.1\nwindow_m = 12\nstep_threshold_m = 0.3\n"
      "[Map_insertOpts]\nFILL_SAMPLES = 6\n",
      p);
  EXPECT_TRUE(warnings.empty()) << warnings.front();
  EXPECT_EQ(p.resolution_m, 0.1);
  EXPECT_EQ(p.window_m, 12);
  EXPECT_EQ(p.step_threshold_m, 0.3);
  EXPECT_EQ(p.fill_samples, 6);
}

TEST(ParametersIni, comments_behind_a_value_are_no_part_of_it)
{
  Parameters p;
  load(
      "[Map_insertOpts]\nclearance_m = 0.7 // [m]\nlambda_t = 2 ; eq. 4\na_beam = 0.002 # m/m\n",
      p);
  EXPECT_EQ(p.clearance_m, 0.7);
  EXPECT_EQ(p.lambda_t, 2);
  EXPECT_EQ(p.a_beam, 0.002);
}

TEST(ParametersIni, an_unknown_key_is_warned_with_section_and_nearest_known_name)
{
  for (const auto& [section, unknown, known] : std::vector<std::array<std::string, 3>>{
           {"Map_insertOpts", "clearence_m", "clearance_m"},
           {"Map_creationOpts", "backendx", "backend"},
           {"Map_creationOpts", "threadsx", "threads"},
           {"Map_creationOpts", "devicex", "device"},
           {"Map_creationOpts", "keep_wholex", "keep_whole"},
           {"Map_insertOpts", "foo", ""},
           {"Map_insertOpts", "fill_rule", ""}})
  {
    Parameters p;
    const auto warnings = load("[" + section + "]\n// x = 1\n" + unknown + " = 1\n", p);
    ASSERT_EQ(warnings.size(), 1U) << unknown;
    EXPECT_TRUE(has(warnings[0], "'" + unknown + "' in section [" + section + "]"));
    const std::string nearest = "nearest known name is '" + known + "'";
    EXPECT_EQ(has(warnings[0], known.empty() ? "nearest" : nearest), !known.empty()) << warnings[0];
  }
}

TEST(ParametersIni, sections_that_nothing_reads_are_warned)
{
  Parameters p;
  const auto wrong_ending = load("[Map_creationOpts]\n[Map_insertionOpts]\nclearance_m=1\n", p);
  ASSERT_FALSE(wrong_ending.empty());
  EXPECT_TRUE(has(wrong_ending.back(), "[Map_insertionOpts]"));
  const auto none = load("[Other]\nclearance_m=1\n", p);
  ASSERT_EQ(none.size(), 1U);
  EXPECT_TRUE(has(none[0], "no section [Map_creationOpts]"));
}

// MRPT takes what is in the first square brackets for a place in a source, and cuts it out.
TEST(ParametersIni, what_mrpt_prints_of_an_error_is_the_whole_of_it)
{
  for (const std::string text :
       {"[Map_insertOpts]\nmax_range_m = abc\n", "[Map_insertOpts]\nwindow_m = 5000\n",
        "[Map_creationOpts]\nbackend = tpu\n"})
  {
    const CConfigFileMemory cfg(text);
    Parameters p;
    talus::Backend backend = talus::Backend::Auto;
    int threads = 1, device = 0;
    const std::string message = message_of(
        [&]
        {
          talus::load_parameters(cfg, "Map", p);
          talus::load_execution(cfg, "Map", backend, threads, device);
        });
    ASSERT_NE(message, "no error") << text;
    const mrpt::ExceptionWithCallBack<std::runtime_error> thrown{std::runtime_error(message)};
    EXPECT_TRUE(has(mrpt::exception_to_str(thrown), message));
  }
}

TEST(ParametersIni, an_error_names_the_file_where_there_is_one)
{
  const std::string file = testing::TempDir() + "talus_parameters_ini.ini";
  const auto message = [&](const std::string& text)
  {
    std::ofstream(file) << "[Map_insertOpts]\n" << text;
    Parameters p;
    return message_of([&] { talus::load_parameters(mrpt::config::CConfigFile(file), "Map", p); });
  };
  const std::string value = message("lambda_t = x\n"), line = message("\nlambda_t 2\n");
  EXPECT_TRUE(has(value, "(in section Map_insertOpts of " + file + ")"));
  EXPECT_EQ(line.rfind(file + ":3: 'lambda_t 2' has no '='", 0), 0U) << line;
  std::remove(file.c_str());
}

TEST(ParametersIni, what_mrpt_would_drop_without_a_word_is_refused_with_its_line)
{
  using namespace std::string_literals;
  const std::vector<std::pair<std::string, std::string>> flaws{
      {"[Map_a]\nx 1\n", "f.ini:2: 'x 1' has no '='"},
      {"[Map_a]\r\n\r\nx 1 ; = m\r\n", "f.ini:3: 'x 1' has no '='"},
      {"[Map_a]\ny = \\\n2\n= 1\n", "f.ini:4: '= 1' has no name"},
      {"[Map_a]\nx = 1\ny = 1\n X= 2\n", "f.ini:4: 'X' is given again, first in line 2"},
      {"[Map_b]\nx = 1\n[map_B]\nx = 2\n", "f.ini:4: 'x' is given again, first in line 2"},
      {"[Map_a]\n# see \\\nx = 1\n", "f.ini:2: a comment that ends in a backslash"},
      {"[Map_a]\nx = 1 // m \\\ny = 1\n", "f.ini:2: a comment that ends in a backslash"},
      {"[Map_a] x = 1\n", "f.ini:1: nothing behind the name of a section is read"},
      {"[Other]\n[Map_a\nx = 1\n", "f.ini:2: the name of this section has no closing bracket"},
      {"[Map_a]\nx = 1\0\n"s, "f.ini:2: a NUL byte"},
      {"[Other]\n\0\n[Map_a]\n"s, "f.ini:2: a NUL byte"}};
  for (const auto& [text, flaw] : flaws)
    EXPECT_EQ(flaw_of(text).rfind(flaw, 0), 0U) << flaw_of(text);
}

TEST(ParametersIni, what_mrpt_understands_and_the_sections_of_others_are_left_alone)
{
  for (const std::string text :
       {"", "\xef\xbb\xbf[Map_a] // the first\nx = 1\n[Map_b]\nx = 1\n",
        "; a\n  # b\n[Map_a]\n// x = 1\n// x = 2\nno = // value\n",
        "@define N 3 \\\n[Map_a]\nx = ${N}\n@define M x\ny = $eval{2 * N}\n",
        "[Map_a]\nx = 1 + \\\r\n  2 + \\\n  3 ; six\ny = 1 = 2",
        "[Other]\nx\nx = 1\nx = 1\n[Map_a\\\n]\nx = 1\n[Map\nx\n[Map_aa] y\nz\n"})
    EXPECT_EQ(flaw_of(text), "no error") << text;
}

TEST(ParametersIni, what_an_error_quotes_is_short_and_shows_in_any_terminal_and_in_mrpt)
{
  const auto quote_of = [](const std::string& line)
  {
    const std::string flaw = flaw_of("[Map_a]\n" + line);
    const auto from = flaw.find('\''), to = flaw.find("' has no '='");
    return flaw.substr(from + 1, to - from - 1);
  };
  EXPECT_EQ(quote_of("x\033[2J"), "x...");
  EXPECT_EQ(quote_of("range [m]"), "range ...");
  EXPECT_EQ(quote_of(std::string(10000, 'x')), std::string(60, 'x') + "...");
}

TEST(ParametersIni, a_parameter_with_and_without_its_unit_is_refused)
{
  const std::string message =
      error_of("[Map_creationOpts]\nresolution_m = 0.1\nresolution = 0.2\n");
  EXPECT_TRUE(has(message, "resolution_m is given twice"));
  EXPECT_TRUE(has(message, "(in section Map_creationOpts)"));
}

TEST(ParametersIni, options_refuse_what_mrpt_would_read_as_some_other_value)
{
  talus::CDualElevationMap::TLikelihoodOptions likelihood;
  talus::CDualElevationMap::TRenderOptions render;
  talus::ObstacleOptions obstacles;
  const std::vector<std::pair<mrpt::config::CLoadableOptions*, std::string>> wrong{
      {&likelihood, "sigma_m = 0.05m"},    {&likelihood, "outlierRatio = "},
      {&likelihood, "decimation = 2.7"},   {&likelihood, "decimation = 1e12"},
      {&render, "showGround = maybe"},     {&render, "maxCells = many"},
      {&obstacles, "seen_within_m = far"}, {&obstacles, "z_m = nan"},
      {&obstacles, "unseen = "},           {&obstacles, "boundary_only = 2"}};
  for (const auto& [options, line] : wrong)
  {
    const std::string key = line.substr(0, line.find(' ')), value = line.substr(key.size() + 3);
    const std::string message = message_of(
        [&, o = options, l = line] { o->loadFromConfigFile(CConfigFileMemory("[S]\n" + l), "S"); });
    EXPECT_EQ(message.rfind(key + " = '" + value + "': must be ", 0), 0U) << message;
    EXPECT_TRUE(has(message, "(in section S)"));
  }
}

TEST(ParametersIni, a_bad_value_names_section_key_value_and_range_and_changes_nothing)
{
  for (const std::string value : {"-0.05", "0", "abc", "nan", "", "0.05m"})
  {
    const std::string message = error_of("[Map_creationOpts]\nresolution_m = " + value + "\n");
    EXPECT_TRUE(has(message, "(in section Map_creationOpts)")) << value << ": " << message;
    EXPECT_TRUE(has(message, "resolution_m = '" + value + "'"));
    EXPECT_TRUE(has(message, "0.001 to 100 m"));
  }
  EXPECT_TRUE(has(error_of("[Map_insertOpts]\nfill_samples = 2.5\n"), "fill_samples"));

  Parameters p;
  EXPECT_THROW(load("[Map_insertOpts]\nclearance_m = 0.9\nlambda_t = x\n", p), std::runtime_error);
  EXPECT_EQ(p.clearance_m, Parameters().clearance_m);
}

TEST(ParametersIni, a_window_of_a_hundred_thousand_cells_is_refused_with_the_sections_named)
{
  const std::string message =
      error_of("[Map_creationOpts]\nresolution = 1\nwindow = 100000\n[Map_insertOpts]\n");
  EXPECT_TRUE(has(message, "(in sections Map_creationOpts and Map_insertOpts)"));
  EXPECT_TRUE(has(message, "100000"));
}

TEST(ParametersIni, backend_threads_and_device_are_read_and_checked)
{
  talus::Backend backend = talus::Backend::Auto;
  int threads = 1, device = 0;
  CConfigFileMemory good(
      std::string("[Map_creationOpts]\nbackend = CPU // here\nthreads = 4\ndevice = 1\n"));
  talus::load_execution(good, "Map", backend, threads, device);
  EXPECT_EQ(backend, talus::Backend::Cpu);
  EXPECT_EQ(threads, 4);
  EXPECT_EQ(device, 1);
  for (const std::string bad :
       {"backend = gpu", "threads = -1", "threads = many", "device = -1", "device = first"})
  {
    CConfigFileMemory cfg("[Map_creationOpts]\n" + bad + "\n");
    EXPECT_THROW(talus::load_execution(cfg, "Map", backend, threads, device), std::runtime_error)
        << bad;
  }
}

TEST(ParametersIni, the_shipped_files_load_without_a_warning)
{
  const std::string folder = TALUS_SOURCE_DIR "/datasets/configs/";
  for (const auto& [file, prefix] :
       {std::pair{"talus-map.ini", "CDualElevationMap"},
        {"car.ini", "CDualElevationMap"},
        {"nuscenes_car.ini", "CDualElevationMap"},
        {"paper.ini", "CDualElevationMap"},
        {"reactive2d_config.ini", "CDualElevationMap"},
        {"reactive3d_config.ini", "CDualElevationMap"},
        {"observations2map.ini", "MappingApplication_terrain_00"},
        {"icp-slam.ini", "MappingApplication_terrain_00"},
        {"rbpf-slam.ini", "MappingApplication_terrain_00"},
        {"pf-localization.ini", "MetricMap_terrain_00"}})
  {
    Parameters p;
    const auto warnings =
        talus::load_parameters(mrpt::config::CConfigFile(folder + file), prefix, p);
    EXPECT_TRUE(warnings.empty()) << file << ": " << warnings.front();
  }
}

TEST(ParametersIni, the_file_of_any_car_has_no_body_and_that_of_nuscenes_differs_in_its_own_only)
{
  const auto of = [](const std::string& name)
  {
    Parameters p;
    const std::string file = TALUS_SOURCE_DIR "/datasets/configs/" + name;
    talus::load_parameters(mrpt::config::CConfigFile(file), "CDualElevationMap", p);
    return p;
  };
  const Parameters car = of("car.ini");
  Parameters nuscenes = of("nuscenes_car.ini");
  EXPECT_TRUE(car.body_boxes_m.empty());
  EXPECT_FALSE(nuscenes.body_boxes_m.empty());
  nuscenes.body_boxes_m.clear();
  for (const auto& info : talus::parameter_table())
    EXPECT_TRUE(talus::is_same_value(info, car, nuscenes)) << info.name;
}

TEST(PlannerIni, weighs_as_many_factors_as_this_mrpt_whether_it_was_written_for_an_older_or_a_newer)
{
  const bool wants_8 = talus::detail::kHolonomicFactors == 8;
  const std::string fitted = wants_8 ? "[0.5, 0, 0, 1, 0, 0, 2, 0]" : "[0.5, 0, 0, 1, 0, 0, 2]";
  for (const std::string written : {"[0.5 , 0, 0, 1, 0, 0,2]  // comment", "0.5 0 0 1 0 0 2 0"})
  {
    CConfigFileMemory ini(
        "[CHolonomicFullEval]\nfactorWeights = " + written +
        "\n[CHolonomicND]\nfactorWeights = 1 2 3 4\n");
    talus::fit_planner_ini(ini);
    EXPECT_EQ(talus::ini_value(ini, "CHolonomicFullEval", "factorWeights"), fitted);
    EXPECT_FALSE(ini.keyExists("CHolonomicFullEval", "factorNormalizeOrNot"));
    EXPECT_EQ(talus::ini_value(ini, "CHolonomicND", "factorWeights"), "1 2 3 4");
  }
}

TEST(PlannerIni, keeps_a_list_of_any_other_length_for_mrpt_to_refuse)
{
  CConfigFileMemory ini(std::string("[CHolonomicFullEval]\nfactorWeights = 1 2\n"));
  talus::fit_planner_ini(ini);
  EXPECT_EQ(talus::ini_value(ini, "CHolonomicFullEval", "factorWeights"), "1 2");
}

// With TALUS_WRITE_DOC=1 in the environment this writes the table of the page instead of checking
// it.
TEST(ParametersIni, the_page_of_parameters_is_up_to_date)
{
  const std::string path = TALUS_SOURCE_DIR "/doc/parameters.md";
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  std::string page = text.str();
  const std::string begin = "<!-- table -->\n";
  const auto from = page.find(begin) + begin.size(), to = page.find("<!-- end -->");
  ASSERT_TRUE(from > begin.size() && from < to && to < page.size());
  if (std::getenv("TALUS_WRITE_DOC"))
    std::ofstream(path) << page.replace(from, to - from, talus::parameters_as_markdown());
  else
    EXPECT_EQ(page.substr(from, to - from), talus::parameters_as_markdown())
        << "run this test once with TALUS_WRITE_DOC=1";
}
