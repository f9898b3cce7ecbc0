// A map that one thread feeds while a planner's thread reads it.
#include <talus/interleaved_points.h>
#include <talus/live_map.h>
#include <talus/map_view.h>

#include <atomic>
#include <cstdio>
#include <thread>

#include "made_up_scans.h"

int main()
{
  using talus::Layer;
  talus::LiveMap map({}, {Layer::Traversability});  // what snapshots shall have
  std::atomic<bool> is_over{false};

  std::thread sensor(
      [&]
      {
        talus::InterleavedPoints points;
        for (int i = 0; i < 20; i++)
        {
          const double x_m = 0.1 * i;
          const Cloud cloud = scan_of_road(x_m);
          talus::Frame frame = points.frame(cloud.data(), cloud.size());
          frame.stamp_s = 0.1 * i;  // of another time each: a stamp that comes again is dropped
          frame.T_map_sensor.m[3] = x_m;
          frame.T_map_sensor.m[11] = kSensorHeight_m;
          map.ingest(frame);
        }
        is_over = true;
      });

  std::thread planner(
      [&]
      {
        while (!is_over) std::this_thread::yield();  // a planner would plan, with what is there
        const auto now = map.snapshot();  // stays as it is, whatever the map does meanwhile
        const talus::MapView view(*now);
        std::printf("after frame %d:\n", static_cast<int>(now->frame));
        std::printf("  on the road  %.1f\n", view.at(Layer::Traversability, 4.0, 0.0));
        std::printf("  at the block %.1f\n", view.at(Layer::Traversability, 2.8, 0.5));
      });
  sensor.join();
  planner.join();
}
