// A world of the simulator: what is read can be looked at.
#include <talus/sim/world.h>

#include <cmath>
#include <vector>

#include "fuzz.h"

using namespace talus;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  sim::World world;
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (!fuzz::is_read([&] { world = sim::parse_world(text, "world.yaml"); })) return 0;
  fuzz::require(!world.robot.waypoints.empty(), "a robot is somewhere");
  const sim::Scene scene(world, 1.0);
  const auto from = world.robot.waypoints.front();
  fuzz::require(std::isfinite(world.ground.height_m(from.x, from.y)), "the ground has a height");
  std::vector<sim::Span> spans;
  scene.column(from.x, from.y, spans);
  return 0;
}
