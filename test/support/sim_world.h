#pragma once
#include <talus/sim/drive.h>
#include <talus/sim/truth.h>

#include <string>

#include "message_of.h"

/** Small worlds for tests of the simulator, and what is to be known of a point in them. */
namespace talus::sim
{
constexpr double kExact_m = 1e-9;
constexpr const char* kFlat = "- plane: {z_m: 0}\n";

/** A world of this ground and these objects, with a robot that stands at the origin. */
inline World world_of(
    const std::string& ground, const std::string& rest = "",
    const std::string& robot = "{path_m: [[0, 0]], duration_s: 1}")
{
  return parse_world("ground:\n" + ground + rest + "robot: " + robot + "\n", "test.yaml");
}

/** Why a world cannot be read. */
inline std::string error_of(const std::string& text)
{
  return message_of([&] { parse_world(text, "bad.yaml"); });
}

/** Range of the first hit from a point in a direction, -1 without. */
inline double cast_m(const World& world, const Vec3& from, const Vec3& toward)
{
  const auto hit = Scene(world, 0).cast({from, normalized(toward)}, 100);
  return hit ? hit->range_m : -1;
}

struct Cell
{
  float ground, top, underside, label;
};
/** The cell of 5 cm that has its corner nearest to the origin at (x, y). */
inline Cell cell_at(
    const World& world, double x_m, double y_m, double time_s = 0, bool movers = true)
{
  TruthOptions options;
  options.movers = movers;
  const Truth t = truth(world, {x_m, y_m, 1, 1, 0.05}, time_s, options);
  return {t.ground[0], t.obstacle_top[0], t.underside[0], t.label[0]};
}

}  // namespace talus::sim
