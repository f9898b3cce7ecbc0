#include "options.h"

#include "../common/command_line.h"
#include "../common/log_name.h"

namespace talus::calibrate
{
namespace
{
constexpr const char* kFooter =
    "Writes into DIR: calibration.ini (lines for the map's INI file), sensors-pose.ini (for\n"
    "'rawlog-edit --sensors-pose'), calibration.json (everything), calibration.png (before and\n"
    "after). They appear together. A log that cannot be used, or a fit that makes the frames held\n"
    "out from it worse, writes nothing and says why.\n"
    "\n"
    "Examples:\n"
    "  talus-calibrate drive.rawlog --trajectory drive.tum --output calibration\n"
    "  rawlog-edit --sensors-pose calibration/sensors-pose.ini -i drive.rawlog -o fixed.rawlog\n"
    "      and the same for all other logs of this robot\n"
    "  talus-calibrate drive.rawlog --base-height 0.12\n"
    "      the trajectory (drive.tum) is that of a point 12 cm above the ground\n"
    "  talus-calibrate drive.rawlog --mount 0.2,0,0.68,0,0,0\n"
    "      the log does not know where the sensor is mounted\n"
    "\n"
    "Exit codes: 0 done, 1 failed, 2 wrong usage, 128 + N stopped by signal N.";

void add_inputs(CLI::App& app, AppOptions& o)
{
  app.add_option("LOG", o.log, "Rawlog (plain, gz or zstd) of a drive")
      ->required()
      ->check(app::not_empty())
      ->type_name("");
  app.add_option(
         "--trajectory", o.trajectory,
         "Poses of the robot: TUM text or .simplemap (default: LOG.tum beside it, else its own)")
      ->check(app::not_empty())
      ->type_name("FILE");
  app.add_option("--max-gap", o.max_gap_s, "Poses farther apart than this are not joined [s]")
      ->check(app::between(0.001, 1e6))
      ->capture_default_str()
      ->type_name("S");
  app.add_option("--sensor", o.sensor, "Label of the sensor (default: the only one)")
      ->check(app::not_empty())
      ->type_name("LABEL");
  app::add_mounting(
      app, "--mount", o.mounting, "Mounting to start from (default: as the log says)");
  app.add_option(
         "--time-offset", o.time_offset_s,
         "To start from: added to the log's stamps, gives the trajectory's time [s]")
      ->check(app::between(-1e6, 1e6))
      ->capture_default_str()
      ->type_name("S");
  app.add_option("--max-offset", o.fit.max_time_offset_s, "A larger time offset is refused [s]")
      ->check(app::between(0.0, 10.0))
      ->capture_default_str()
      ->type_name("S");
}

void add_model(CLI::App& app, AppOptions& o)
{
  app.add_option(
         "--base-height", o.base_height_m,
         "Height of the trajectory's reference point above the ground under the robot [m]")
      ->check(app::between(-10.0, 10.0))
      ->capture_default_str()
      ->type_name("M");
  app.add_flag_callback(
      "--no-contact", [&o] { o.fit.use_contact = false; },
      "Do not use that the robot stands on the ground, parallel to it");
  app.add_option("--max-range", o.thinning.max_range_m, "Points farther away are not used [m]")
      ->check(app::between(1.0, 200.0))
      ->capture_default_str()
      ->type_name("M");
  app.add_option_function<std::string>(
         "--noise",
         [&o](const std::string& kind)
         {
           o.fit.noise_kind = kind == "beam"     ? NoiseKind::Beam
                              : kind == "height" ? NoiseKind::Height
                                                 : NoiseKind::Auto;
         },
         "Where the sensor errs: beam, height, or auto: as the log says (default: auto)")
      ->check(CLI::IsMember({"auto", "beam", "height"}))
      ->type_name("KIND");
  app.add_option(
         "--hold-out", o.thinning.hold_out_every,
         "Keep every Nth frame from the fit, to judge it by")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str()
      ->type_name("N");
}

}  // namespace

void add_options(CLI::App& app, AppOptions& options)
{
  app.description(
      "Finds how a LiDAR is mounted, how its clock is off and how it errs, from the log of a "
      "drive.");
  add_inputs(app, options);
  add_model(app, options);
  app.add_option("--output", options.output, "Folder of the results (default: LOG_calibration)")
      ->check(app::not_empty())
      ->type_name("DIR");
  app.add_flag("--quiet", options.quiet, "Print warnings and errors only");
  app.footer(kFooter);
  app.final_callback(
      [&options]
      {
        if (options.output.empty()) options.output = app::name_of_log(options.log) + "_calibration";
      });
}

}  // namespace talus::calibrate
