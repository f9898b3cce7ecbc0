#include <talus/elevation_mapper.h>
#ifdef WITH_MRPT
#include <talus/mrpt/CDualElevationMap.h>
#endif

#include <cstdio>

int main()
{
  const float x = 1, y = 1, z = -0.7f;
  talus::Frame frame;
  frame.x_m = &x;
  frame.y_m = &y;
  frame.z_m = &z;
  frame.size = 1;
  talus::ElevationMapper map({}, talus::Backend::Cpu);
  const auto report = map.update(frame);
#ifdef WITH_MRPT
  const talus::CDualElevationMap mrpt_map;
  if (!mrpt_map.isEmpty()) return 1;
#endif
  std::printf("%u point accepted\n", report.points_accepted);
  return report.points_accepted == 1 ? 0 : 1;
}
