// talus-export: a map of terrain in, the same in formats of other programs out.
#include "../common/child_process.h"
#include "../common/crash_context.h"
#include "../common/export/export_files.h"
#include "../common/output_folder.h"
#include "../common/printable.h"
#include "options.h"

#include <exception>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace fs = std::filesystem;
using namespace talus::formats;
using talus::app::code_of;

namespace
{
constexpr const char* kLessMemory =
    "The map is read as a whole: cut out a part of it with gdal_translate, or take a machine with "
    "more memory";
void print_error(const std::string& text) { std::cerr << "talus-export: " << text << "\n"; }

/** "monday/site" for "logs/monday/site.tif". */
std::string title_of(const fs::path& file)
{
  return (fs::absolute(file).parent_path().filename() / file.stem()).string();
}

std::string folder_for(const std::string& file, const Options& o)
{
  return o.output.empty() ? fs::path(file).parent_path().string() : o.output;
}

/** Before the work: no file is written over an input or over another one. */
void require_files_apart(const Options& o)
{
  std::vector<std::string> inputs = o.inputs;
  inputs.push_back(o.exports.changes);
  std::map<fs::path, std::string> written_for;
  for (const std::string& file : o.inputs)
  {
    const auto files = talus::app::files_of_export(file, folder_for(file, o), o.exports);
    talus::app::require_apart("", files, inputs);
    for (const std::string& written : files)
    {
      const auto [first, is_new] =
          written_for.emplace(fs::weakly_canonical(fs::absolute(written)), file);
      if (!is_new && !talus::app::is_same_file(first->second, file))
        throw std::runtime_error(
            first->second + " and " + file + ": both would be written as " + written +
            "; export them one by one, each with an --output of its own");
    }
  }
}

void export_all(const Options& o)
{
  require_files_apart(o);
  for (const std::string& file : o.inputs)
    for (const std::string& path : talus::app::export_files(
             file, folder_for(file, o), o.title.empty() ? title_of(file) : o.title, o.exports))
      if (!o.quiet) std::cout << "  wrote   " << path << "\n";
}

/** Makes --output where it is missing. */
int run(const Options& o)
{
  std::unique_ptr<talus::app::OutputFolder> folder;
  std::error_code none;
  if (!o.output.empty() && !fs::is_directory(o.output, none))
    folder = std::make_unique<talus::app::OutputFolder>(o.output);
  const auto work = [&o]
  {
    export_all(o);
    return 0;
  };
  return talus::app::run_command_in_child(o.inputs.front(), kLessMemory, work, print_error);
}
}  // namespace

int main(int argc, char** argv)
{
  const talus::app::PrintableOutput printable;
  Options options;
  if (const auto code = parse_options(argc, argv, options)) return *code;
  const auto work = [&options]
  {
    talus::app::forward_signals();
    return run(options);
  };
  return code_of(work, print_error, options.output, kLessMemory);
}
