#include "options.h"

#include "../common/command_line.h"
#include "../common/version.h"

#include <iostream>

namespace talus::site
{
namespace
{
constexpr const char* kFooter =
    "Each cell of the result is told by the best evidence: measured before filled from two sides\n"
    "before presumed before filled from one. Heights of equal evidence that agree within --step "
    "become their "
    "mean,\n"
    "weighed by their information, which sums; where they contradict, the newest counts. The "
    "order\n"
    "of the maps makes no difference to any byte, but with --align: the first is the frame of "
    "all.\n"
    "\nExamples:\n"
    "  talus-merge monday/site.tif tuesday/site.tif --output site.tif --picture site.png\n"
    "  talus-merge site.tif today/site.tif --output site.tif\n"
    "      adds a drive to the map of all; the old one stays until the new one is complete\n"
    "  talus-merge --changes monday/site.tif friday/site.tif --output changes\n"
    "      changes/changes.tif and changes/changes.png: what was built, dug, removed, placed\n"
    "  talus-merge --align monday/site.tif friday/site.tif --output site.tif\n"
    "      poses of the drives lie in frames that differ by up to 1.5 m, 7 degrees and any height\n"
    "\nExit codes: 0 done, 1 an input or the output failed, 2 wrong usage, 128 + N stopped by "
    "signal "
    "N.";

void add_options(CLI::App& app, Options& o)
{
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
      "Bring all maps into the frame of the first (x, y, z, yaw), where the ground tells it");
  app.add_option("--picture", o.picture, "Also draw the map of all, a PNG")
      ->check(app::not_empty())
      ->type_name("FILE");
  app.add_option("--step", o.merge.step_m, "Heights farther apart contradict each other [m]")
      ->check(app::between(0.0, 100.0))
      ->capture_default_str()
      ->type_name("M");
  app.add_option("--threads", o.merge.threads, "0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--memory", o.memory_mb, "For tiles of the map [MB]; the others wait on the disk")
      ->check(CLI::Range(16, 1'000'000))
      ->capture_default_str()
      ->type_name("MB");
  app.add_flag(
      "--keep-far", o.keep_far,
      "Write one file, however far its parts lie from each other: takes long (default: "
      "what is far has a file of its own)");
  app.add_flag("--quiet", o.quiet, "Print warnings and errors only");
}

/** What no single option tells; empty: all is well. */
std::string mistake(const Options& o)
{
  if (o.changes && o.inputs.size() != 2)
    return "--changes compares two maps, the older first; there are " +
           std::to_string(o.inputs.size());
  if (o.changes && !o.picture.empty())
    return "--picture is of a merged map; --changes draws changes.png";
  return "";
}
}  // namespace

std::optional<int> parse_options(int argc, char** argv, Options& options)
{
  CLI::App app{
      "Fuses the maps of several drives, days or robots, or tells what changed.", "talus-merge"};
  add_options(app, options);
  app.set_version_flag("--version", app::version_line("talus-merge"));
  app.footer(kFooter);
  if (const auto code = app::parse_command_line(app, argc, argv)) return code;
  const std::string wrong = mistake(options);
  if (wrong.empty()) return std::nullopt;
  std::cerr << "talus-merge: " << wrong << "\nRun 'talus-merge --help' for usage.\n";
  return 2;
}

}  // namespace talus::site
