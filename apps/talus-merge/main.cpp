// talus-merge: maps of several drives in, the map of all or what changed out.
#include "../common/child_process.h"
#include "../common/command_line.h"
#include "../common/export/export_formats.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/progress_bar.h"
#include "../common/run_app.h"
#include "fit_report.h"

#include <talus/io/atomic_file.h>
#include <talus/io/map_picture.h>
#include <talus/number_text.h>
#include <talus/site/changes.h>
#include <talus/site/merge.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

namespace app = talus::app;
namespace fs = std::filesystem;
using namespace talus::site;
using talus::align::Alignment;
using talus::app::OutputFolder;
using talus::app::print_error;
using talus::app::ProgressBar;

namespace
{
/** What the command line says. */
struct Options
{
  std::vector<std::string> inputs;  //!< two with `changes`, the older first
  std::string output;  //!< a file, or a folder with `changes`
  std::string picture;  //!< of what was merged; empty: none
  MergeOptions merge;
  std::size_t memory_mb = 512;  //!< for tiles
  bool changes = false, align = false, quiet = false;
  bool keep_far = false;  //!< tiles that lie kilometres from all others, too
};

constexpr const char* kFooter =
    "Each cell of the result has the best evidence: measured before filled from two sides\n"
    "before presumed before filled from one. Heights of equal evidence that agree within --step\n"
    "become their mean, weighed by their information, which sums; where they contradict, the "
    "newest\n"
    "counts. The order of the maps makes no difference to any byte, but with --align: the first "
    "is\n"
    "the frame of all.\n"
    "\nExamples:\n"
    "  talus-merge monday/site.tif tuesday/site.tif --output site.tif --picture site.png\n"
    "  talus-merge site.tif today/site.tif --output site.tif\n"
    "      adds a drive to the map of all; the old one stays until the new one is complete\n"
    "  talus-merge --changes monday/site.tif friday/site.tif --output changes\n"
    "      changes/changes.tif and changes/changes.png: what was built, dug, removed, placed\n"
    "  talus-merge --align monday/site.tif friday/site.tif --output site.tif\n"
    "      poses of the drives lie in frames that differ by up to 1.5 m, 7 degrees and any height, "
    "or\n"
    "      by more, where both have seen much of what stands\n"
    "\nExit codes: 0 done, 1 an input or the output failed, 2 wrong usage, 128 + N stopped by "
    "signal "
    "N.";

/** Refuses what is wrong of several options together. */
void check(const Options& o)
{
  if (o.changes && o.inputs.size() != 2)
    throw CLI::ValidationError(
        "--changes compares two maps, the older first; there are " +
        std::to_string(o.inputs.size()));
  if (o.changes && !o.picture.empty())
    throw CLI::ValidationError("--picture is of a merged map; --changes draws changes.png");
}

void add_options(CLI::App& app, Options& o)
{
  app.description("Fuses the maps of several drives, days or robots, or says what changed.");
  app.footer(kFooter);
  app.add_option(
         "MAP", o.inputs,
         "Maps in one map frame: site.tif of talus-map, with its other floors and islands beside "
         "it")
      ->required()
      ->check(app::not_empty());
  app.add_option("--output", o.output, "The map of all; with --changes: folder of the files")
      ->required()
      ->check(app::not_empty())
      ->type_name("FILE");
  app.add_flag("--changes", o.changes, "Of two maps, the older first: write what changed instead");
  app.add_flag(
      "--align", o.align,
      "Bring all maps into the frame of the first (x, y, z, yaw), where the ground determines it");
  app::add_text(app, "--picture", o.picture, "FILE", "Also draw the map of all, a PNG");
  app::add_number(
      app, "--step", o.merge.step_m, 0.0, 100.0, "M",
      "Heights farther apart contradict each other [m]");
  app::add_number(app, "--threads", o.merge.threads, 0, 1024, "N", "0: all cores");
  app::add_number(
      app, "--memory", o.memory_mb, 16, 1'000'000, "MB",
      "For tiles of the map [MB]; the others wait on the disk");
  app.add_flag(
      "--keep-far", o.keep_far,
      "Write one file, however far its parts lie from each other: takes long (default: "
      "what is far has a file of its own)");
  app.add_flag("--quiet", o.quiet, "Print warnings and errors only");
  app.final_callback([&o] { check(o); });
}

constexpr const char* kLessMemory = "Give less with --memory, or merge fewer maps at once";
constexpr int kMaxComparedPairs = 8;  // pairs of maps, which takes as long as to merge them
constexpr double kAligning = 0.2, kMerging = 0.5;  // done, of the time

std::size_t memory_bytes(const Options& o) { return o.memory_mb << 20; }

std::string square_metres(double area_m2) { return talus::fixed_text(area_m2, 2) + " m2"; }

/** Drives count their floors as they come to them. */
int lowest_floor(const std::vector<std::string>& paths)
{
  int lowest = info_of_site(paths.front()).floor;
  for (const std::string& path : paths) lowest = std::min(lowest, info_of_site(path).floor);
  return lowest;
}

/** What --align finds; nothing moves without it. */
std::vector<Alignment> aligned(const Options& o)
{
  if (!o.align) return std::vector<Alignment>(o.inputs.size());
  ProgressBar bar("talus-merge", !o.quiet);
  return talus::align::align_sites(
      o.inputs, [&](double done) { bar.show(kAligning * done, "aligning"); });
}

void warn(const std::string& warning)
{
  if (!warning.empty()) print_error(warning);
}

/** Looks closer at those that lie aside or have changed. */
void warn_of_doubtful(const std::vector<MapFit>& fits, const Options& o)
{
  int looked_at = 0;
  for (const MapFit& fit : fits)
  {
    if (!is_doubtful(fit) || ++looked_at > kMaxComparedPairs) continue;
    const auto both = talus::align::align_sites({o.inputs[fit.first], o.inputs[fit.second]});
    warn(warning_of_alignment(fit, o.inputs, both.back()));
  }
}

void print_fits(
    const std::vector<Alignment>& alignments, const std::vector<MapFit>& fits, const Options& o)
{
  for (std::size_t i = 1; i < alignments.size() && o.align && !o.quiet; ++i)
    std::cout << "  aligned " << text_of_alignment(alignments[i], o.inputs[i]) << "\n";
  for (const MapFit& fit : fits)
  {
    if (!o.quiet) std::cout << "  fit     " << text_of_fit(fit, o.inputs) << "\n";
    warn(warning_of_fit(fit, o.inputs, o.align));
  }
  if (!o.align) warn_of_doubtful(fits, o);
}

std::string name_of(const std::string& file) { return fs::path(file).filename().string(); }

std::string title_of(const std::vector<std::string>& files)
{
  constexpr std::size_t kMaxNamed = 3;
  if (files.size() > kMaxNamed) return std::to_string(files.size()) + " maps";
  std::string all;
  for (const std::string& file : files) all += (all.empty() ? "" : " + ") + app::name_of_map(file);
  return all;
}

std::string folder_of(const std::string& file)
{
  const fs::path folder = fs::path(file).parent_path();
  return folder.empty() ? "." : folder.string();
}

/** Where a file is made. */
std::string made_in(const std::string& staging, const std::string& file)
{
  return (fs::path(staging) / name_of(file)).string();
}

/** Merges and writes. How the maps fit, and what is known. */
std::vector<MapFit> merge(
    const Options& o, const std::string& staging, const std::string& picture,
    const std::vector<Alignment>& alignments, double& known_m2)
{
  ProgressBar bar("talus-merge", !o.quiet);
  Site site(info_of_site(o.inputs.front()).resolution_m, memory_bytes(o), staging);
  site.name = title_of(o.inputs);
  const int floor = lowest_floor(o.inputs);
  MergeOptions options = o.merge;
  for (const Alignment& a : alignments) options.shifts.push_back(a.shift);
  auto fits = merge_sites(
      o.inputs, site, floor, options,
      [&](double done) { bar.show(kAligning + (kMerging - kAligning) * done, "merging"); });
  if (!o.keep_far)
    for (const std::string& text : texts_of_islands(o.output, site)) warn("warning: " + text);
  write_site_files(
      made_in(staging, o.output), picture, site,
      [&](double done) { bar.show(kMerging + (1 - kMerging) * done, "writing"); },
      o.keep_far ? Far::Together : Far::Apart);
  const std::string style = fs::path(o.output).replace_extension(".qml").string();
  if (!talus::io::is_users_qgis_style(style)) talus::io::write_qgis_style(made_in(staging, style));
  known_m2 = known_cells(site).area_m2;
  return fits;
}

void merge(const Options& o, const std::string& staging, const std::string& picture)
{
  const std::vector<Alignment> alignments = aligned(o);
  double known_m2 = 0;
  const std::vector<MapFit> fits = merge(o, staging, picture, alignments, known_m2);
  if (!o.quiet)
    std::cout << o.inputs.size() << (o.inputs.size() == 1 ? " map: " : " maps: ")
              << square_metres(known_m2) << " known\n";
  print_fits(alignments, fits, o);
}

void print(const ChangeSums& sums)
{
  const auto line = [&](const char* words, Change c)
  {
    std::cout << "  " << words << square_metres(sums.area_m2(c)) << ", "
              << talus::fixed_text(sums.volume_m3[static_cast<std::size_t>(c)], 2) << " m3\n";
  };
  std::cout << "changed:\n";
  line("built up     ", Change::Built);
  line("dug away     ", Change::Dug);
  line("object gone  ", Change::Gone);
  line("object new   ", Change::Appeared);
}

/** What is new would be reported as gone. */
void warn_of_order(const std::string& from, const std::string& to)
{
  const std::uint32_t from_s = info_of_site(from).newest_s, to_s = info_of_site(to).newest_s;
  if (from_s > to_s)
    print_error(
        "warning: " + from + " was seen " + std::to_string(from_s - to_s) + " s after " + to +
        ": --changes says what changed from the first map to the second; give the older one "
        "first");
}

void compare(const Options& o, const fs::path& to_folder)
{
  const auto site_of = [&](const std::string& path, const Alignment& a, const char* tiles)
  {
    auto site = std::make_unique<Site>(
        info_of_site(o.inputs.front()).resolution_m, memory_bytes(o) / 2,
        (to_folder / tiles).string());
    read_site_files(path, *site, a.shift);
    site->name = app::name_of_map(path);
    return site;
  };
  warn_of_order(o.inputs[0], o.inputs[1]);
  const std::vector<Alignment> alignments = aligned(o);
  const auto from = site_of(o.inputs[0], alignments[0], "tiles_from");
  const auto to = site_of(o.inputs[1], alignments[1], "tiles_to");
  ChangeSums sums;
  for (const int floor : floors_of(*to))
    if (floor == 0 || have_common_tile(*from, *to, floor))
      sums.add(write_changes(
          with_floor((to_folder / "changes.tif").string(), floor),
          with_floor((to_folder / "changes.png").string(), floor), *from, *to, floor,
          o.merge.step_m));
  if (!o.quiet) print(sums);
  print_fits(alignments, {fit_of(*from, *to, 0)}, o);
}

/** Names that no other file of the set has. */
void require_files_apart(const Options& o)
{
  static const std::regex map(".*\\.tiff?"), part(".*_(floor|island)_[0-9]+\\.tiff?");
  const std::string name = name_of(o.output);
  if (!std::regex_match(name, map) || std::regex_match(name, part))
    throw std::runtime_error(
        o.output +
        ": call the map of all NAME.tif; NAME_floor_1.tif and NAME_island_1.tif are parts of " +
        "another one");
  talus::io::require_replaceable(o.output);
  for (const std::string& input : o.inputs)
    if (app::is_part(input, o.output) && app::is_same_file(folder_of(input), folder_of(o.output)))
      throw std::runtime_error(
          input + ": would be replaced as a part of " + o.output +
          ", with which it is read: leave it out, or write elsewhere");
  app::require_apart("", {way_file_of(o.output)}, o.inputs);
  if (o.picture.empty()) return;
  talus::io::require_replaceable(o.picture);
  app::require_apart("", {o.picture}, o.inputs);
  if (fs::path(o.picture).extension() != ".png")
    throw std::runtime_error(o.picture + ": call the picture NAME.png");
}

/** They stay: who knows whose they are. */
void warn_of_old_exports(const fs::path& map)
{
  const fs::path stem = fs::path(map).replace_extension();
  std::error_code none;
  for (const auto& format : app::export_formats())
    for (const std::string& ending : format.endings)
      if (const fs::path file = stem.string() + ending; ending != ".qml" && fs::exists(file, none))
        warn("warning: " + file.string() + " is of the map before: talus-export makes it anew");
}

int run_merge(const Options& o)
{
  require_files_apart(o);
  std::optional<OutputFolder> drawn;  // elsewhere; beside the map the picture comes with it
  if (!o.picture.empty() && !app::is_same_file(folder_of(o.picture), folder_of(o.output)))
    drawn.emplace(folder_of(o.picture));
  const int code = app::make_results(
      folder_of(o.output), name_of(o.output), o.inputs.front(), kLessMemory,
      [&](const std::string& staging)
      {
        const std::string beside = drawn ? drawn->staging() : staging;
        merge(o, staging, o.picture.empty() ? "" : made_in(beside, o.picture));
      });
  if (code != 0) return code;
  if (drawn) drawn->commit(name_of(o.picture));
  warn_of_old_exports(o.output);
  if (!o.quiet) std::cout << "  wrote   " << o.output << "\n";
  return 0;
}

int run_changes(const Options& o)
{
  app::require_apart(o.output, {"changes.tif", "changes.png"}, o.inputs);
  const int code = app::make_results(
      o.output, "changes.tif", o.inputs.front(), kLessMemory,
      [&](const std::string& staging) { compare(o, staging); });
  if (code == 0 && !o.quiet)
    std::cout << "  wrote   " << (fs::path(o.output) / "changes.png").string() << "\n";
  return code;
}
}  // namespace

int main(int argc, char** argv)
{
  const auto run = [](const Options& o) { return o.changes ? run_changes(o) : run_merge(o); };
  return app::run_app<Options>("talus-merge", argc, argv, run);
}
