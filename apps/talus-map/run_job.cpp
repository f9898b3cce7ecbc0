#include "run_job.h"

#include "../common/child_process.h"
#include "../common/crash_context.h"
#include "../common/memory_limit.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/progress_bar.h"
#include "../common/export/export_files.h"
#include "kept_site.h"
#include "label_files.h"
#include "log_mapper.h"
#include "rawlog_out.h"
#include "job.h"

#include <talus/io/map_picture.h>
#include <talus/mrpt/parameters_ini.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
void write_log(RawlogOut& out)
{
  out.write();
  if (!out.externals().empty())
    print_error(
        "warning: the log keeps data in " + out.externals() + "; its copy needs them as " +
        out.externals_of_copy());
}

void print_hints(const Job& job, const LogMapper& mapper)
{
  for (const auto& hint : mapper.summary().hints) print_error("hint: " + job.log + ": " + hint);
}

/** For --strict. */
void require_no_hints(const Job& job, const LogMapper& mapper)
{
  const std::size_t count = mapper.summary().hints.size();
  if (count == 0) return;
  print_hints(job, mapper);
  throw std::runtime_error(
      job.log + ": nothing was written because of " + std::to_string(count) +
      (count == 1 ? " hint" : " hints") + " (--strict): mend that, or leave --strict out");
}

/** Where the files of a job are made. */
struct JobFolders
{
  explicit JobFolders(const Job& job) : results(job.folder)
  {
    if (job.labels.empty()) return;
    require_no_foreign_labels(job.labels);
    labels.emplace(job.labels, "--labels");
  }
  std::string shown(const std::string& error) const
  {
    return results.shown(labels ? labels->shown(error) : error);
  }
  /** The results last, since summary.json says that all is there. */
  void commit()
  {
    if (labels) labels->commit(kLabelTable);
    results.commit("summary.json");
  }

  OutputFolder results;
  std::optional<OutputFolder> labels;
};

/** Labels belong to the points of the log. */
void warn_of_points_left_out(const SourceLog& log, io::RunSummary& run)
{
  if (log.not_finite > 0)
    run.warnings.push_back(
        "the import left out " + std::to_string(log.not_finite) +
        (log.not_finite == 1 ? " point that is" : " points that are") +
        " not finite: the labels of their scans are as many fewer than the points "
        "of their files");
}

/** Makes the log that is read, where the job names scans of another program. */
SourceLog import_first(
    const Job& job, const Options& options, const std::string& folder, const std::string& label)
{
  ProgressBar bar(label, !options.quiet);
  return source_log(
      job, options, folder,
      [&](double done, const std::string& points) { bar.show(done, "importing, " + points); });
}

/** Where on Earth the map is, as far as it is known by now. */
std::optional<io::GeoOrigin> origin_of(const std::optional<KeptSite>& site, const Options& options)
{
  return site ? site->origin() : options.origin;
}

/** Of a site of many kilometres it takes minutes. False where it cannot be written: the map of the
 * window is not lost with it. */
bool write_site(KeptSite& site, const OutputFolder& output, io::RunSummary& run, ProgressBar& bar)
{
  try
  {
    site.write(
        output.staging(), fs::path(run.log).filename().string(),
        [&](double done) { bar.show(done, "writing site.tif"); });
    return true;
  }
  catch (const std::exception& e)
  {
    run.warnings.push_back("the site map is not written: " + output.shown(e.what()));
  }
  std::vector<fs::path> parts;
  for (const auto& file : fs::directory_iterator(output.staging()))
    if (is_site_file(file.path().filename())) parts.push_back(file.path());
  for (const auto& part : parts) fs::remove(part);
  run.site.reset();
  return false;
}

/** Beside each map, unless a user's own is there: what is written replaces files of its name. */
void write_qgis_styles(const Job& job, const OutputFolder& output)
{
  std::vector<fs::path> styles;
  for (const auto& file : fs::directory_iterator(output.staging()))
    if (const auto name = file.path().filename(); name == "map.tif" || is_site_map(name))
      styles.push_back(fs::path(name).replace_extension(".qml"));
  for (const auto& style : styles)
    if (!io::is_users_qgis_style((fs::path(job.folder) / style).string()))
      io::write_qgis_style((fs::path(output.staging()) / style).string());
}

/** True when all is written, false when the site map is not. */
bool map_log(
    const Job& job, const Options& options, const Settings& settings, const std::string& label,
    const JobFolders& folders, RawlogOut* rawlog_out)
{
  const OutputFolder& output = folders.results;
  const std::string folder = output.staging();
  const auto start = std::chrono::steady_clock::now();
  std::optional<KeptSite> site;
  if (options.has_site) site.emplace(options, settings.parameters, folder);
  const SourceLog log = import_first(job, options, folder, label);
  std::optional<LabelFiles> labels;
  if (folders.labels) labels.emplace(folders.labels->staging(), options.labels_as);
  LogMapper mapper(
      job, log, options, settings, site ? &*site : nullptr, labels ? &*labels : nullptr);
  if (labels) warn_of_points_left_out(log, mapper.summary());
  bool is_whole = true;
  {
    ProgressBar bar(label, !options.quiet);
    mapper.run(
        [&](const LogMapper& m, double progress)
        {
          const auto frames = m.summary().frames.size();
          const bool is_snapshot = options.every > 0 && frames % options.every == 0;
          if (is_snapshot) write_snapshot(folder, m, origin_of(site, options));
          if (is_snapshot) ++mapper.summary().snapshots;
          if (rawlog_out && (is_snapshot || options.every == 0)) rawlog_out->add(m);
          bar.show(progress, "frame " + std::to_string(frames));
        });
    if (options.strict) require_no_hints(job, mapper);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    mapper.summary().wall_s = wall.count();
    if (site) is_whole = write_site(*site, output, mapper.summary(), bar);
  }
  write_results(folder, mapper, origin_of(site, options));
  write_qgis_styles(job, output);
  if (rawlog_out) write_log(*rawlog_out);
  const auto& warnings = mapper.summary().warnings;  // those of the settings have been printed
  for (std::size_t i = settings.warnings.size(); i < warnings.size(); ++i)
    print_error("warning: " + job.log + ": " + warnings[i]);
  print_hints(job, mapper);
  if (!options.quiet) std::cout << console_summary(mapper);
  return is_whole;
}

/** In the child: the exit code. */
int map_or_tell(
    const Job& job, const Options& options, const Settings& settings, const std::string& label,
    const JobFolders& folders, RawlogOut* rawlog_out)
{
  try
  {
    keep_memory();
    return map_log(job, options, settings, label, folders, rawlog_out) ? kDone : kWithoutSite;
  }
  catch (const std::bad_alloc&)
  {
    print_error(job.log + ": not enough memory; try a smaller window_m or a larger resolution_m");
  }
  catch (const std::exception& e)
  {
    print_error(folders.shown(e.what()));
  }
  return kSomeFailed;
}

/** The narrower side of the robot's body, where the settings have one. */
double robot_size_m(const Settings& settings, double otherwise_m)
{
  const auto& boxes = settings.parameters.body_boxes_m;
  if (boxes.empty()) return otherwise_m;
  BodyBox all = boxes.front();
  for (const BodyBox& b : boxes)
  {
    all.min_x_m = std::min(all.min_x_m, b.min_x_m);
    all.max_x_m = std::max(all.max_x_m, b.max_x_m);
    all.min_y_m = std::min(all.min_y_m, b.min_y_m);
    all.max_y_m = std::max(all.max_y_m, b.max_y_m);
  }
  return std::min(all.max_x_m - all.min_x_m, all.max_y_m - all.min_y_m);
}

/** The site map, else the map of the window, in a child of its own: what fails there costs no other
 * result. False where something fails. */
bool write_exports(
    const Job& job, const Options& options, const Settings& settings, const OutputFolder& output)
{
  if (options.exports.formats.empty()) return true;
  const auto report = [&](const std::string& text)
  { print_error(job.log + ": " + output.shown(text)); };
  const auto work = [&]
  {
    fs::path map = fs::path(output.staging()) / "site.tif";
    if (!fs::exists(map)) map.replace_filename("map.tif");
    const fs::path name = fs::absolute(job.folder).filename();
    ExportOptions exports = options.exports;
    auto& smallest_m = exports.occupancy.close_islands_m;
    smallest_m = robot_size_m(settings, smallest_m);
    const Exported exported = export_files(
        files_of_map(map.string()), output.staging(), (name / map.stem()).string(), exports);
    for (const std::string& note : exported.notes) report("warning: " + note);
    for (const std::string& error : exported.errors) report(error);
    return exported.errors.empty() ? kDone : kSomeFailed;
  };
  const ChildEnd end = run_in_child(
      [&] { return code_of(work, report, job.folder, "Export it by talus-export, in parts"); });
  if (end.signal && !stop_signal()) report("the export " + crash_text("", end.signal));
  return end.signal == 0 && end.exit_code == kDone;
}
}  // namespace

bool run_job(
    const Job& job, const Options& options, const Settings& settings, const std::string& label)
{
  try
  {
    require_files_apart(job, options);
    JobFolders folders(job);
    OutputFolder& output = folders.results;
    std::unique_ptr<RawlogOut> rawlog_out;
    if (!options.rawlog_out.empty())
      rawlog_out = std::make_unique<RawlogOut>(
          options.rawlog_out, path_of_log(job, options, output.staging()));
    const auto work = [&]
    { return map_or_tell(job, options, settings, label, folders, rawlog_out.get()); };
    const ChildEnd end = run_in_child(work);
    const bool is_mapped = end.signal == 0 && end.exit_code != kSomeFailed;
    const bool is_exported = is_mapped && write_exports(job, options, settings, output);
    if (stop_signal())
      print_error(job.log + ": stopped; nothing was written");
    else if (end.signal)
      print_error(
          crash_text(job.log, end.signal) +
          (end.signal == SIGKILL ? ". Try a smaller window_m or a larger resolution_m" : ""));
    else if (is_mapped)
    {
      if (rawlog_out) rawlog_out->commit();
      folders.commit();
      const bool is_whole = end.exit_code == kDone;
      if (is_whole && is_exported) return true;
      print_error(
          job.log + ": everything but " + (is_whole ? "" : "its site map") +
          (is_whole || is_exported ? "" : " and ") + (is_exported ? "" : "some of its exports") +
          " is in " + job.folder);
    }
  }
  catch (const std::exception& e)
  {
    print_error(job.log + ": " + e.what());
  }
  return false;
}

bool suggest_settings(const Job& job, const Options& options, const Settings& settings)
{
  std::optional<OutputFolder> hidden;
  if (job.needs_import) hidden.emplace(options.output.empty() ? "." : options.output);
  const auto work = [&]
  {
    const std::string name = name_of_source(job.log);
    const SourceLog log = import_first(job, options, hidden ? hidden->staging() : "", name);
    LogMapper mapper(job, log, options, settings);
    {
      ProgressBar bar(name, !options.quiet);
      mapper.run([&](const LogMapper& m, double progress)
                 { bar.show(progress, "frame " + std::to_string(m.summary().frames.size())); });
    }
    std::cout << suggestion_ini(mapper) << std::flush;
    return kDone;
  };
  const auto report = [&](const std::string& text)
  { print_error(hidden ? hidden->shown(text) : text); };
  return run_command_in_child(job.log, kLookAtLog, work, report) == kDone;
}

bool settings_work(const Settings& settings)
{
  const auto make = [&]
  {
    try
    {
      const ElevationMapper map(
          settings.parameters, settings.backend, settings.threads, settings.device.value_or(0));
      return kDone;
    }
    catch (const std::exception& e)
    {
      print_error(
          "--backend " + backend_text(settings.backend) + ": " + e.what() +
          "; --backend cpu gives the same map");
      return kSomeFailed;
    }
  };
  const ChildEnd end = run_in_child(make);
  if (end.signal) print_error("the backend crashed: " + signal_text(end.signal));
  return end.signal == 0 && end.exit_code == kDone;
}

int count_devices()
{
  constexpr int kMax = 255;  // the largest exit code
  return run_in_child([=] { return std::min(cuda_devices(), kMax); }).exit_code;
}

}  // namespace talus::app
