// talus-import: scans of other programs in, a log for talus-map out.
#include "../common/child_process.h"
#include "../common/crash_context.h"
#include "../common/import/import_log.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/printable.h"
#include "../common/progress_bar.h"
#include "options.h"

#include <talus/number_text.h>

#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>

namespace fs = std::filesystem;
using namespace talus::import;
using talus::app::OutputFolder;
using talus::app::ProgressBar;

namespace
{
constexpr const char* kLessAtOnce = "Import fewer sources at once";

void print_error(const std::string& text) { std::cerr << "talus-import: " << text << "\n"; }

/** What lies beside a log counts as its poses. */
void require_no_old_poses(const std::string& tum)
{
  if (fs::exists(tum))
    throw std::runtime_error(
        tum +
        ": lies there already, but these scans have no poses, and talus-map would take those. "
        "Remove it, pass --poses, or give the log another name.");
}

void tell(const Options& o, const ImportedLog& log)
{
  std::cout << o.output << ": " << contents_text(log) << "\n";
  if (log.poses.count)
    std::cout << "  poses   " << log.poses.count << " of " << log.poses.source << ", over "
              << talus::fixed_text(log.poses.length_m, 1) << " m\n";
  else
    std::cout << "  poses   none: talus-map needs --trajectory FILE, or --static\n";
  for (const auto& remark : log.remarks) std::cout << "  note    " << remark << "\n";
}

ImportedLog import_into(const Options& o, const fs::path& folder)
{
  const std::string log = (folder / fs::path(o.output).filename()).string();
  const std::string tum =
      (folder / fs::path(talus::app::trajectory_beside(o.output)).filename()).string();
  ProgressBar bar("talus-import", !o.quiet);
  return import_log(
      o.sources, o.import, log, tum,
      [&](double done, const std::string& points) { bar.show(done, points); });
}

void import_all(const Options& o, const fs::path& folder)
{
  const ImportedLog log = import_into(o, folder);
  if (log.poses.count == 0) require_no_old_poses(talus::app::trajectory_beside(o.output));
  if (!o.quiet) tell(o, log);
}

void require_all_apart(const Options& o)
{
  auto inputs = o.sources;
  if (!o.import.source.poses.empty()) inputs.push_back(o.import.source.poses);
  talus::app::require_apart("", {o.output, talus::app::trajectory_beside(o.output)}, inputs);
}

/** The exit code. */
int run(const Options& o)
{
  require_all_apart(o);
  const fs::path output(o.output);
  OutputFolder folder(output.has_parent_path() ? output.parent_path().string() : ".");
  const auto work = [&]
  {
    import_all(o, folder.staging());
    return 0;
  };
  const auto to_tell = [&](const std::string& text) { print_error(folder.told(text)); };
  if (const int code =
          talus::app::run_command_in_child(o.sources.front(), kLessAtOnce, work, to_tell))
    return code;
  const std::string tum = talus::app::trajectory_beside(o.output);
  const bool has_poses = fs::exists(fs::path(folder.staging()) / fs::path(tum).filename());
  folder.commit(output.filename().string());
  if (!o.quiet) std::cout << "  wrote   " << o.output << (has_poses ? " and " + tum : "") << "\n";
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
    return run(options);
  };
  return talus::app::code_of(work, print_error, options.sources.front(), kLessAtOnce);
}
