// talus-merge: maps of several drives in, the map of all or what changed out.
#include "../common/child_process.h"
#include "../common/crash_context.h"
#include "../common/export/export_formats.h"
#include "../common/output_folder.h"
#include "../common/printable.h"
#include "../common/progress_bar.h"
#include "fit_report.h"
#include "options.h"

#include <talus/io/atomic_file.h>
#include <talus/io/qgis_style.h>
#include <talus/number_text.h>
#include <talus/site/changes.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>
#include <talus/site/site_way.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

namespace fs = std::filesystem;
using namespace talus::site;
using talus::align::Alignment;
using talus::app::OutputFolder;
using talus::app::ProgressBar;

namespace
{
constexpr const char* kLessMemory = "Give less with --memory, or merge fewer maps at once";
constexpr int kMostLookedAt = 8;  // pairs of maps, which takes as long as to merge them
constexpr double kAligning = 0.2, kMerging = 0.5;  // done, of the time

void print_error(const std::string& text) { std::cerr << "talus-merge: " << text << "\n"; }

std::size_t memory_bytes(const Options& o) { return o.memory_mb << 20; }

std::string square_metres(double area_m2) { return talus::fixed_text(area_m2, 2) + " m2"; }

/** Drives count their floors as they come to them. */
int lowest_floor(const std::vector<std::string>& paths)
{
  int lowest = floor_of_site(paths.front());
  for (const std::string& path : paths) lowest = std::min(lowest, floor_of_site(path));
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
    if (!is_doubtful(fit) || ++looked_at > kMostLookedAt) continue;
    const auto both = talus::align::align_sites({o.inputs[fit.first], o.inputs[fit.second]});
    warn(warning_of_alignment(fit, o.inputs, both.back()));
  }
}

void tell_fits(
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

/** Of a file and where it is made. */
struct Place
{
  explicit Place(const std::string& path)
      : file(path), folder(file.has_parent_path() ? file.parent_path().string() : ".")
  {
    talus::io::require_replaceable(path);
  }
  std::string made() const { return (fs::path(folder.staging()) / file.filename()).string(); }
  void commit() { folder.commit(file.filename().string()); }

  fs::path file;
  OutputFolder folder;
};

/** Merges and writes. How the maps fit, and what is known. */
std::vector<MapFit> merge(
    const Options& o, const Place& to, const Place* picture,
    const std::vector<Alignment>& alignments, double& known_m2)
{
  ProgressBar bar("talus-merge", !o.quiet);
  Site site(resolution_of_site(o.inputs.front()), memory_bytes(o), to.folder.staging());
  const int floor = lowest_floor(o.inputs);
  MergeOptions options = o.merge;
  for (const Alignment& a : alignments) options.shifts.push_back(a.shift);
  auto fits = merge_sites(
      o.inputs, site, floor, options,
      [&](double done) { bar.show(kAligning + (kMerging - kAligning) * done, "merging"); });
  if (!o.keep_far)
    for (const std::string& text : texts_of_islands(o.output, site)) warn("warning: " + text);
  write_site_files(
      to.made(), picture ? picture->made() : "", site,
      [&](double done) { bar.show(kMerging + (1 - kMerging) * done, "writing"); },
      o.keep_far ? Far::Together : Far::Apart);
  const fs::path style = fs::path(o.output).replace_extension(".qml");
  if (!talus::io::is_users_qgis_style(style.string()))
    talus::io::write_qgis_style((fs::path(to.folder.staging()) / style.filename()).string());
  known_m2 = known_cells(site).area_m2;
  return fits;
}

void merge(const Options& o, const Place& to, const Place* picture)
{
  const std::vector<Alignment> alignments = aligned(o);
  double known_m2 = 0;
  const std::vector<MapFit> fits = merge(o, to, picture, alignments, known_m2);
  if (!o.quiet)
    std::cout << o.inputs.size() << (o.inputs.size() == 1 ? " map: " : " maps: ")
              << square_metres(known_m2) << " known\n";
  tell_fits(alignments, fits, o);
}

void tell(const ChangeSums& sums)
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

/** What is new would be told as gone. */
void warn_of_order(const std::string& from, const std::string& to)
{
  const std::uint32_t from_s = newest_of_site(from), to_s = newest_of_site(to);
  if (from_s > to_s)
    print_error(
        "warning: " + from + " was seen " + std::to_string(from_s - to_s) + " s after " + to +
        ": --changes tells what changed from the first map to the second; give the older one "
        "first");
}

void compare(const Options& o, const fs::path& to_folder)
{
  const auto site_of = [&](const std::string& path, const Alignment& a, const char* tiles)
  {
    auto site = std::make_unique<Site>(
        resolution_of_site(o.inputs.front()), memory_bytes(o) / 2, (to_folder / tiles).string());
    read_site_files(path, *site, a.shift);
    return site;
  };
  warn_of_order(o.inputs[0], o.inputs[1]);
  const std::vector<Alignment> alignments = aligned(o);
  const auto from = site_of(o.inputs[0], alignments[0], "tiles_from");
  const auto to = site_of(o.inputs[1], alignments[1], "tiles_to");
  ChangeSums sums;
  for (const int floor : floors_of(*to))
    if (floor == 0 || have_common_place(*from, *to, floor))
      sums.add(write_changes(
          with_floor((to_folder / "changes.tif").string(), floor),
          with_floor((to_folder / "changes.png").string(), floor), *from, *to, floor,
          o.merge.step_m));
  if (!o.quiet) tell(sums);
  tell_fits(alignments, {fit_of(*from, *to, 0)}, o);
}

/** Works in a child, which a damaged file or a signal may end. The exit code. */
int in_child(
    const Options& o, const std::function<void()>& work, const OutputFolder* folder = nullptr)
{
  const auto done = [&work]
  {
    work();
    return 0;
  };
  const auto tell = [folder](const std::string& text)
  { print_error(folder ? folder->told(text) : text); };
  return talus::app::run_command_in_child(o.inputs.front(), kLessMemory, done, tell);
}

void require_files_apart(const Options& o)
{
  talus::app::require_apart("", {way_file_of(o.output)}, o.inputs);
  if (o.picture.empty()) return;
  talus::app::require_apart("", {o.picture}, o.inputs);
  if (talus::app::is_same_file(o.picture, o.output))
    throw std::runtime_error(
        "'" + o.picture + "' is named for the map and for its picture; give two names");
}

/** They stay: who knows whose they are. */
void warn_of_old_exports(const fs::path& map)
{
  const fs::path stem = fs::path(map).replace_extension();
  std::error_code none;
  for (const auto& format : talus::app::export_formats())
    for (const std::string& ending : format.endings)
      if (const fs::path file = stem.string() + ending; ending != ".qml" && fs::exists(file, none))
        warn("warning: " + file.string() + " is of the map before: talus-export makes it anew");
}

int run_merge(const Options& o)
{
  require_files_apart(o);
  Place to(o.output);
  std::optional<Place> picture;
  if (!o.picture.empty()) picture.emplace(o.picture);
  const auto work = [&] { merge(o, to, picture ? &*picture : nullptr); };
  if (const int code = in_child(o, work, &to.folder)) return code;
  to.commit();
  if (picture) picture->commit();
  warn_of_old_exports(o.output);
  if (!o.quiet) std::cout << "  wrote   " << o.output << "\n";
  return 0;
}

int run_changes(const Options& o)
{
  talus::app::require_apart(o.output, {"changes.tif", "changes.png"}, o.inputs);
  OutputFolder folder(o.output);
  const auto work = [&] { compare(o, folder.staging()); };
  if (const int code = in_child(o, work, &folder)) return code;
  folder.commit("changes.tif");
  if (!o.quiet) std::cout << "  wrote   " << (fs::path(o.output) / "changes.png").string() << "\n";
  return 0;
}
}  // namespace

int main(int argc, char** argv)
{
  const talus::app::PrintableOutput printable;
  Options options;
  if (const auto code = parse_options(argc, argv, options)) return *code;
  const auto work = [&options]
  {
    talus::app::forward_signals();  // before any folder is made: a signal must not leave it behind
    return options.changes ? run_changes(options) : run_merge(options);
  };
  return talus::app::code_of(work, print_error, options.output, kLessMemory);
}
