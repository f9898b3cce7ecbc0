#include <gtest/gtest.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/exceptions.h>
#include <talus/mrpt/parameters_ini.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

using mrpt::config::CConfigFileMemory;
using talus::Parameters;

namespace
{
std::vector<std::string> load(const std::string& text, Parameters& p)
{
  return talus::load_parameters(CConfigFileMemory(text), "Map", p);
}

/** The message of the std::runtime_error that loading the text throws. */
std::string error_of(const std::string& text)
{
  Parameters p;
  try
  {
    load(text, p);
  }
  catch (const std::runtime_error& e)
  {
    return e.what();
  }
  return "no error";
}

bool contains(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}
}  // namespace

TEST(ParametersIni, every_parameter_is_accepted_in_either_section)
{
  Parameters p;
  const auto warnings = load(
      "[Map_creationOpts]\nresolution = 0.1\nwindow_m = 12\nstep_threshold_m = 0.3\n"
      "[Map_insertOpts]\nFILL_RULE = minimum\nfill_samples = 6\n",
      p);
  EXPECT_TRUE(warnings.empty()) << warnings.front();
  EXPECT_EQ(p.resolution_m, 0.1);
  EXPECT_EQ(p.window_m, 12);
  EXPECT_EQ(p.step_threshold_m, 0.3);
  EXPECT_EQ(p.fill_rule, talus::FillRule::Minimum);
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
  Parameters p;
  const auto warnings = load("[Map_insertOpts]\nclearence_m = 0.7\n", p);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "'clearence_m'")) << warnings[0];
  EXPECT_TRUE(contains(warnings[0], "[Map_insertOpts]")) << warnings[0];
  EXPECT_TRUE(contains(warnings[0], "'clearance_m'")) << warnings[0];
}

TEST(ParametersIni, sections_that_nothing_reads_are_warned)
{
  Parameters p;
  const auto wrong_ending = load("[Map_creationOpts]\n[Map_insertionOpts]\nclearance_m=1\n", p);
  ASSERT_FALSE(wrong_ending.empty());
  EXPECT_TRUE(contains(wrong_ending.back(), "[Map_insertionOpts]")) << wrong_ending.back();
  const auto none = load("[Other]\nclearance_m=1\n", p);
  ASSERT_EQ(none.size(), 1U);
  EXPECT_TRUE(contains(none[0], "no section [Map_creationOpts]")) << none[0];
}

TEST(ParametersIni, an_unknown_key_that_is_near_to_nothing_gets_no_name)
{
  Parameters p;
  const auto warnings = load("[Map_insertOpts]\nfoo = 1\n", p);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "'foo' in section [Map_insertOpts]")) << warnings[0];
  EXPECT_FALSE(contains(warnings[0], "nearest")) << warnings[0];
}

// MRPT takes what is in the first square brackets for a place in a source, and cuts it out.
TEST(ParametersIni, what_mrpt_prints_of_an_error_is_the_whole_of_it)
{
  for (const std::string text :
       {"[Map_insertOpts]\nmax_range_m = abc\n", "[Map_insertOpts]\nwindow_m = 5000\n",
        "[Map_creationOpts]\nbackend = tpu\n"})
    try
    {
      const CConfigFileMemory cfg(text);
      Parameters p;
      talus::Backend backend = talus::Backend::Auto;
      int threads = 1;
      talus::load_parameters(cfg, "Map", p);
      talus::load_execution(cfg, "Map", backend, threads);
      ADD_FAILURE() << "nothing thrown for " << text;
    }
    catch (const std::runtime_error& e)
    {
      const std::string shown =
          mrpt::exception_to_str(mrpt::ExceptionWithCallBack<std::runtime_error>(e));
      EXPECT_TRUE(contains(shown, e.what())) << shown;
    }
}

TEST(ParametersIni, an_error_names_the_file_where_there_is_one)
{
  const std::string file = testing::TempDir() + "talus_parameters_ini.ini";
  std::ofstream(file) << "[Map_insertOpts]\nlambda_t = x\n";
  Parameters p;
  try
  {
    talus::load_parameters(mrpt::config::CConfigFile(file), "Map", p);
    FAIL() << "nothing thrown";
  }
  catch (const std::runtime_error& e)
  {
    EXPECT_TRUE(contains(e.what(), "(in section Map_insertOpts of " + file + ")")) << e.what();
  }
  std::remove(file.c_str());
}

TEST(ParametersIni, a_bad_value_names_section_key_value_and_range_and_changes_nothing)
{
  for (const std::string value : {"-0.05", "0", "abc", "nan", "", "0.05m"})
  {
    const std::string message = error_of("[Map_creationOpts]\nresolution_m = " + value + "\n");
    EXPECT_TRUE(contains(message, "(in section Map_creationOpts)")) << value << ": " << message;
    EXPECT_TRUE(contains(message, "resolution_m = '" + value + "'")) << message;
    EXPECT_TRUE(contains(message, "0.001 to 100 m")) << message;
  }
  EXPECT_TRUE(contains(error_of("[Map_insertOpts]\nfill_rule = best\n"), "exchanged"));
  EXPECT_TRUE(contains(error_of("[Map_insertOpts]\nfill_samples = 2.5\n"), "fill_samples"));

  Parameters p;
  EXPECT_THROW(load("[Map_insertOpts]\nclearance_m = 0.9\nlambda_t = x\n", p), std::runtime_error);
  EXPECT_EQ(p.clearance_m, Parameters().clearance_m);
}

TEST(ParametersIni, a_window_of_a_hundred_thousand_cells_is_refused_with_the_sections_named)
{
  const std::string message =
      error_of("[Map_creationOpts]\nresolution = 1\nwindow = 100000\n[Map_insertOpts]\n");
  EXPECT_TRUE(contains(message, "(in sections Map_creationOpts and Map_insertOpts)")) << message;
  EXPECT_TRUE(contains(message, "100000")) << message;
}

TEST(ParametersIni, backend_and_threads_are_read_and_checked)
{
  talus::Backend backend = talus::Backend::Auto;
  int threads = 1;
  CConfigFileMemory good(std::string("[Map_creationOpts]\nbackend = CPU // here\nthreads = 4\n"));
  talus::load_execution(good, "Map", backend, threads);
  EXPECT_EQ(backend, talus::Backend::Cpu);
  EXPECT_EQ(threads, 4);
  for (const std::string bad : {"backend = gpu", "threads = -1", "threads = many"})
  {
    CConfigFileMemory cfg("[Map_creationOpts]\n" + bad + "\n");
    EXPECT_THROW(talus::load_execution(cfg, "Map", backend, threads), std::runtime_error) << bad;
  }
}

TEST(ParametersIni, what_is_saved_loads_as_the_same_values)
{
  Parameters p;
  p.resolution_m = 0.125;
  p.fill_rule = talus::FillRule::Printed;
  p.fill_use_ray_bound = false;
  p.cleanup_frames = 5;
  CConfigFileMemory cfg;
  talus::save_parameters(cfg, "Map_insertOpts", p);
  Parameters loaded;
  EXPECT_TRUE(talus::load_parameters(cfg, "Map", loaded).empty());
  for (const auto& info : talus::parameter_table())
    EXPECT_EQ(info.get(loaded), info.get(p)) << info.name;
}

TEST(ParametersIni, the_shipped_files_load_without_a_warning)
{
  const std::string folder = TALUS_SOURCE_DIR "/datasets/configs/";
  for (const auto& [file, prefix] :
       {std::pair{"talus-map.ini", "CDualElevationMap"},
        {"car.ini", "CDualElevationMap"},
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

// With TALUS_WRITE_DOC=1 in the environment this writes the page instead of checking it.
TEST(ParametersIni, the_page_of_parameters_is_up_to_date)
{
  const std::string path = TALUS_SOURCE_DIR "/doc/parameters.md";
  if (std::getenv("TALUS_WRITE_DOC")) std::ofstream(path) << talus::parameters_as_markdown();
  std::stringstream page;
  page << std::ifstream(path).rdbuf();
  EXPECT_EQ(page.str(), talus::parameters_as_markdown())
      << "run this test once with TALUS_WRITE_DOC=1";
}
