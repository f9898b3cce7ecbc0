#include "options.h"

#include "../common/command_line.h"
#include "../common/settings.h"

#include <talus/layers.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>

#include <cmath>

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

int port_from(const std::vector<std::string>& given)
{
  constexpr int kDefault = 8070, kMax = 65535;
  if (given.empty() || given.front().empty()) return kDefault;
  const auto port = number_from(given.front());
  if (!port || *port != std::floor(*port) || *port < 1 || *port > kMax)
    throw CLI::ValidationError("--page", "'" + given.front() + "' is no port: 1 to 65535");
  return static_cast<int>(*port);
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
  app.add_option_function<std::vector<std::string>>(
         "--page", [&o](const std::vector<std::string>& port) { o.page = port_from(port); },
         "Shows the map in browsers, at this port (default: 8070)")
      ->expected(0, 1)
      ->type_name("PORT");
  app.add_option(
         "--page-address", o.page_address,
         "Address of this machine at which the page is; 0.0.0.0: also for other machines")
      ->needs("--page")
      ->check(not_empty())
      ->capture_default_str()
      ->type_name("ADDRESS");
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
  auto* record = app.add_flag(
      "--record", o.record,
      "Also write record.rawlog and record.tum, of which talus-map makes the same map again; and "
      "make it again where map -> odom jumps");
  app.add_option(
         "--corrected-path", o.corrected_path,
         "Make the map again with the poses of this topic (nav_msgs/Path) when they change")
      ->needs(record)
      ->check(not_empty())
      ->type_name("NAME");
  app.add_option(
         "--corrected-trajectory", o.corrected_trajectory,
         "Make it again with the poses of this file (TUM text) whenever it is written anew")
      ->needs(record)
      ->check(not_empty())
      ->type_name("FILE");
  app.add_flag("--quiet", o.quiet, "Print warnings and errors only");
}

}  // namespace talus::app
