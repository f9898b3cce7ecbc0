#pragma once
// A folder with a small world, and talus-compare run in it.
#include "command_run.h"

namespace fs = std::filesystem;
using Outcome = talus::test::CommandEnd;

class ComparedWorlds : public talus::test::CommandTest
{
 protected:
  ComparedWorlds() : CommandTest(TALUS_COMPARE_EXE)
  {
    write_world("small", "[3, 1]", "[0.5, 0.5, 0.5]");
  }

  /** A floor with one box: NAME.yaml, where NAME may have folders before it. */
  void write_world(const std::string& name, const char* at_m, const char* size_m) const
  {
    write(
        name + ".yaml", "name: " + fs::path(name).filename().string() +
                            "\nseed: 4\nground: [plane: {z_m: 0}]\nobjects: [box: {at_m: " + at_m +
                            ", size_m: " + size_m + "}]\nrobot: {path_m: [[0, 0], [1, 0]]}\n");
  }
  /** A third of the floor is behind it and not seen: the budget `reach` fails. */
  void write_world_with_wall(const std::string& name) const
  {
    write_world(name, "[1.7, 0]", "[0.2, 5, 2]");
  }

  nlohmann::json comparison() const { return json("out/comparison.json"); }

  /** log/small.rawlog, of 11 frames. */
  void write_small_log() const { done(TALUS_SIM_EXE " small.yaml --output log"); }
};
