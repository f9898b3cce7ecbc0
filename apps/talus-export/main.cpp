// talus-export: a map of terrain in, the same in formats of other programs out.
#include "../common/child_process.h"
#include "../common/crash_context.h"
#include "../common/export/export_files.h"
#include "../common/export/export_formats.h"
#include "../common/output_folder.h"
#include "../common/printable.h"
#include "options.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace fs = std::filesystem;
using namespace talus::formats;
using talus::app::code_of;
using talus::app::OutputFolder;

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
  if (!o.output.empty()) return o.output;
  const fs::path beside = fs::path(file).parent_path();
  return beside.empty() ? "." : beside.string();
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

/** By its name. */
using Folders = std::map<std::string, std::unique_ptr<OutputFolder>>;

/** The exit code: what fails costs no other file. */
int export_all(const Options& o, const Folders& folders)
{
  require_files_apart(o);
  int code = 0;
  for (const std::string& file : o.inputs)
  {
    const OutputFolder& folder = *folders.at(folder_for(file, o));
    const auto tell = [&](const std::string& text) { print_error(folder.told(text)); };
    const auto work = [&]
    {
      const auto told = talus::app::export_files(
          file, folder.staging(), o.title.empty() ? title_of(file) : o.title, o.exports);
      for (const std::string& note : told.notes) tell("warning: " + note);
      for (const std::string& error : told.errors) tell(error);
      return told.errors.empty() ? 0 : 1;
    };
    code = std::max(code, code_of(work, tell, file, kLessMemory));
  }
  return code;
}

/** Puts all files of a folder in their place, together. */
void commit(const std::string& name, OutputFolder& folder, const Options& o)
{
  std::set<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder.staging()))
    if (entry.is_regular_file()) files.insert(entry.path().filename());
  if (files.empty()) return;
  folder.commit(files.begin()->string());
  for (const fs::path& file : files)
    if (!o.quiet && talus::app::is_main_file(file.string()))
      std::cout << "  wrote   " << (fs::path(name) / file).lexically_normal().string() << "\n";
}

int run(const Options& o)
{
  Folders folders;
  for (const std::string& file : o.inputs)
    if (auto& folder = folders[folder_for(file, o)]; !folder)
      folder = std::make_unique<OutputFolder>(folder_for(file, o));
  const auto work = [&] { return export_all(o, folders); };
  const int code =
      talus::app::run_command_in_child(o.inputs.front(), kLessMemory, work, print_error);
  if (talus::app::stop_signal() == 0)
    for (const auto& [name, folder] : folders) commit(name, *folder, o);
  return code;
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
