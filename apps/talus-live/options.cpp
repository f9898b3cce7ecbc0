#include "options.h"

#include "../common/command_line.h"
#include "../common/settings.h"

#include <talus/layers.h>
#include <talus/mrpt/parameters_ini.h>

namespace talus::app
{
namespace
{
constexpr const char* kFooter =
    "It joins the network of a robot with ROS 2 as one more participant; no ROS is needed. It "
    "maps\n"
    "the clouds of all topics with sensor_msgs/PointCloud2, or of those that --topic names, at "
    "the\n"
    "poses that /tf and /tf_static tell, or else a topic with nav_msgs/Odometry. Ctrl-C, or the\n"
    "signal TERM, ends it: then DIR gets site.tif and pictures, as from talus-map.\n"
    "It publishes /talus/map and /talus/window (nav_msgs/OccupancyGrid), /talus/map_updates,\n"
    "/talus/obstacles (sensor_msgs/PointCloud2), /talus/path, and with --layers /talus/grid_map.\n"
    "ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS and\n"
    "CYCLONEDDS_URI count as in ROS.\n"
    "\nExamples:\n"
    "  talus-live --config datasets/configs/car.ini\n"
    "  talus-live --record --output yard\n"
    "      then: talus-map yard/record.rawlog -s window_m=20\n"
    "  talus-live --topic /front/points --topic /rear/points --output yard\n"
    "  talus-live --mount /points=0.2,0,0.6,0,0,0\n"
    "\nExit codes: 0 done, 1 the network or the output failed or nothing was mapped, 2 wrong "
    "usage.";

void add_input(CLI::App& app, Options& o)
{
  app.add_option(
         "--topic", o.source.topics,
         "Only the clouds of this topic; again for each (default: all that look like scans)")
      ->allow_extra_args(false)
      ->check(not_empty())
      ->type_name("NAME");
  app.add_option("--domain", o.domain, "Of the network (default: ROS_DOMAIN_ID, else 0)")
      ->check(CLI::Range(0, 232))
      ->type_name("N");
  app.add_option("--max-wait", o.max_wait_s, "How long a cloud waits for its pose [s]")
      ->check(between(0.0, 5.0))
      ->capture_default_str()
      ->type_name("S");
  app.add_option(
         "--base-frame", o.source.base_frame,
         "The base in TF (else base_link, base_footprint or the child of odometry)")
      ->type_name("NAME");
  app.add_option("--map-frame", o.source.map_frame, "The map in TF (else map, or odom)")
      ->type_name("NAME");
  app.add_option_function<std::vector<std::string>>(
         "--mount",
         [&o](const std::vector<std::string>& all)
         {
           for (const auto& text : all)
             if (const auto wrong = import::read_mounting(text, o.source); !wrong.empty())
               throw CLI::ValidationError("--mount", wrong);
         },
         "Where a sensor is on the base [m, degrees], instead of TF; again for each")
      ->allow_extra_args(false)
      ->type_name(std::string("TOPIC=") + kMountingForm);
}

void add_map(CLI::App& app, Options& o)
{
  add_map_settings(app, o.config, o.overrides, o.backend);
  add_optional(app, "--threads", o.threads, "Threads of the CPU backend, 0: all cores (default: 0)")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  app.add_option(
         "--resume", o.resume, "Site map of an earlier run to go on with, in the same map frame")
      ->check(not_empty())
      ->type_name("SITE.tif");
  app.add_option(
         "--memory", o.memory_mb,
         "Memory of the site map [MB]; what finds no room waits in the output folder")
      ->check(between(4, 1e7))
      ->capture_default_str()
      ->type_name("MB");
}
void add_output(CLI::App& app, Options& o)
{
  app.add_option("--hz", o.hz, "How often the window is published; 0: nothing is published")
      ->check(between(0.0, 100.0))
      ->capture_default_str()
      ->type_name("HZ");
  app.add_option(
         "--layers", o.layers,
         "Layers of the window for /talus/grid_map (grid_map_msgs/GridMap), with commas between")
      ->delimiter(',')
      ->check([](const std::string& name)
              { return find_layer(name) ? "" : "there is no layer '" + name + "'"; })
      ->allow_extra_args(false)
      ->type_name("NAME,...");
  app.add_option("--output", o.output, "Folder of the results")
      ->check(not_empty())
      ->capture_default_str()
      ->type_name("DIR");
}
}  // namespace

void add_options(CLI::App& app, Options& o)
{
  app.description("Maps the terrain around a robot with ROS 2 while it drives.");
  app.footer(kFooter);
  add_input(app, o);
  add_map(app, o);
  add_output(app, o);
  app.add_option("--save-every", o.save_every_min, "Also write the results so often [min]")
      ->check(between(0.0, 1e5))
      ->type_name("MIN");
  app.add_flag(
      "--record", o.record,
      "Also write record.rawlog and record.tum, of which talus-map makes the same map again");
  app.add_flag("--quiet", o.quiet, "Print warnings and errors only");
}

}  // namespace talus::app
