// talus-calibrate: the mounting, the clock and the noise of a sensor, from the log of a drive.
#include "../common/output_folder.h"
#include "../common/progress_bar.h"
#include "../common/run_app.h"
#include "outputs.h"
#include "options.h"

#include <talus/io/atomic_file.h>
#include <talus/io/mrpt_error.h>
#include <talus/number_text.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>

namespace fs = std::filesystem;
using namespace talus::calibrate;

namespace
{
constexpr const char* kShorterLog = "Try a part of the log, which rawlog-edit --cut makes";
constexpr double kReading = 0.4;  // share of the time

void write_results(
    const std::string& folder, const AppOptions& options, const LoadedLog& log,
    const Result& result)
{
  const fs::path to(folder);
  const auto write = [&](const char* name, const std::string& text)
  { talus::io::write_file((to / name).string(), text); };
  write("calibration.ini", calibration_ini(options, log, result));
  write("sensors-pose.ini", sensors_pose_ini(log, result));
  write("calibration.json", calibration_json(options, log, result));
  write_picture(
      (to / "calibration.png").string(), fs::path(options.log).filename().string(), result);
}

/** The trajectory's point may not be the one on the ground that --base-height says. */
void warn_of_base_height(const AppOptions& o, const LoadedLog& log, Result& r)
{
  constexpr double kFarOff_m = 0.3;
  const double change_m = r.estimate[kZ] - log.T_base_sensor.z();
  if (!o.fit.use_contact || std::abs(change_m) < kFarOff_m) return;
  char text[240];
  std::snprintf(
      text, sizeof text,
      "z changed by %.2f m: is the trajectory's reference point %.2f m above the ground, as "
      "--base-height says? If it is at %.2f m, z was right",
      change_m, o.base_height_m, o.base_height_m + change_m);
  r.warnings.emplace_back(text);
}

std::string millimetres(double m) { return talus::fixed_text(1000 * m, 1) + " mm"; }

/** What to say of a fit that does not pay. */
std::string doubt(const Result& r)
{
  const auto &before = r.held_out.before, &after = r.held_out.after;
  return "the fit is not recommended: the frames held out from it hardly lie better on the ground "
         "than with the mounting as given (thickness " +
         millimetres(before.thickness_m) + " -> " + millimetres(after.thickness_m) +
         ", 95 % within " + millimetres(before.p95_m) + " -> " + millimetres(after.p95_m) +
         "). Keep the mounting as given, or take a longer drive with bends to both sides and "
         "slopes";
}

/** What to say of a fit that is not worth writing. */
std::string refusal(const Result& r)
{
  const auto &before = r.held_out.before, &after = r.held_out.after;
  const std::string why =
      after.points == 0
          ? "shows no ground in the frames held out from the fit"
          : "was fitted, but the frames held out from the fit lie better on the ground with the "
            "mounting as given (" +
                millimetres(before.thickness_m) + " thick) than as fitted (" +
                millimetres(after.thickness_m) + ")";
  return why +
         ": nothing was written. Are the poses those of this drive, and good to a few "
         "centimetres? Else take a longer drive with bends and slopes";
}

void calibrate_log(const AppOptions& options, const std::string& folder)
{
  talus::app::ProgressBar bar("talus-calibrate", !options.quiet);
  const LoadedLog log =
      load_log(options, [&](double share) { bar.show(kReading * share, "reading"); });
  Options fit = options.fit;
  fit.given = vector_of(log.T_base_sensor, options.time_offset_s);
  fit.progress = [&](double share, const std::string& what)
  { bar.show(kReading + (1 - kReading) * share, what); };
  Result result;
  try
  {
    result = calibrate(log.scans, log.track, fit);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(options.log + ": " + e.what());
  }
  if (result.gains_nothing) throw std::runtime_error(options.log + ": " + refusal(result));
  if (log.is_rolled_over)
    result.warnings.emplace_back(
        "the sensor is mounted upside down: its roll was looked for near " +
        talus::fixed_text(fit.given[kRoll] / parameter_infos()[kRoll].per_unit, 1) +
        " degrees, half a turn from what was given");
  if (result.is_doubtful) result.warnings.push_back(doubt(result));
  warn_of_base_height(options, log, result);
  write_results(folder, options, log, result);
  bar.show(1, "done");
  for (const auto& warning : result.warnings)
    talus::app::print_error("warning: " + options.log + ": " + warning);
  if (!options.quiet) std::cout << console_report(options, log, result);
}

/** The exit code. */
int run(const AppOptions& options)
{
  talus::app::require_apart(
      options.output,
      {"calibration.ini", "sensors-pose.ini", "calibration.json", "calibration.png"},
      {options.log, options.trajectory});
  const int code = talus::app::make_results(
      options.output, "calibration.json", options.log, kShorterLog,
      [&](const std::string& staging) { calibrate_log(options, staging); });
  if (code == 0 && !options.quiet)
    std::cout << "  wrote   " << (fs::path(options.output) / "calibration.ini").string() << "\n";
  return code;
}
}  // namespace

int main(int argc, char** argv) { return talus::app::run_app("talus-calibrate", argc, argv, run); }
