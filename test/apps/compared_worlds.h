#pragma once
// A folder with a small world, and talus-compare run in it.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace fs = std::filesystem;

struct Outcome
{
  int code = 0;
  std::string text;
};

class ComparedWorlds : public testing::Test
{
 protected:
  void SetUp() override
  {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write_world("small", "[3, 1]", "[0.5, 0.5, 0.5]");
  }
  void TearDown() override { fs::remove_all(folder_); }

  /** A floor with one box: NAME.yaml, where NAME may have folders before it. */
  void write_world(const std::string& name, const char* at_m, const char* size_m) const
  {
    fs::create_directories(fs::path(path(name)).parent_path());
    std::ofstream(path(name + ".yaml"))
        << "name: " << fs::path(name).filename().string()
        << "\nseed: 4\nground: [plane: {z_m: 0}]\n"
        << "objects: [box: {at_m: " << at_m << ", size_m: " << size_m << "}]\n"
        << "robot: {path_m: [[0, 0], [1, 0]]}\n";
  }
  /** A third of the floor is behind it and not seen: the budget `reach` fails. */
  void write_world_with_wall(const std::string& name) const
  {
    write_world(name, "[1.7, 0]", "[0.2, 5, 2]");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Outcome run_command(const std::string& command) const
  {
    const std::string log = path("log.txt");
    const int status = std::system((command + " >" + log + " 2>&1").c_str());
    return {WEXITSTATUS(status), read("log.txt")};
  }
  Outcome run(const std::string& arguments) const
  {
    return run_command(std::string(TALUS_COMPARE_EXE) + " " + arguments);
  }

  /** log/small.rawlog, of 11 frames. */
  void write_small_log() const
  {
    const Outcome sim = run_command(
        std::string(TALUS_SIM_EXE) + " " + path("small.yaml") + " --output " + path("log"));
    ASSERT_EQ(sim.code, 0) << sim.text;
  }

  static std::ptrdiff_t hidden_in(const std::string& folder)
  {
    return std::count_if(
        fs::directory_iterator(folder), fs::directory_iterator(),
        [](const auto& entry) { return entry.path().filename().string().front() == '.'; });
  }

  std::string read(const std::string& name) const
  {
    std::ostringstream out;
    out << std::ifstream(path(name), std::ios::binary).rdbuf();
    return out.str();
  }

 private:
  fs::path folder_ = fs::temp_directory_path() / ("talus_compare_test_" + std::to_string(getpid()));
};
