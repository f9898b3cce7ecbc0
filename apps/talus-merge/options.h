#pragma once
#include <talus/site/merge.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace talus::site
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

/** Reads the command line; answers --help, --version and mistakes itself. The exit code of the
 * program, or nothing: go on. */
std::optional<int> parse_options(int argc, char** argv, Options& options);

}  // namespace talus::site
