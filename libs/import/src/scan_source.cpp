#include <talus/import/scan_source.h>
#include <talus/io/packed_log.h>
#include <talus/text.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "formats.h"
#include "placed_scans.h"
#include "whole_map.h"

namespace fs = std::filesystem;

namespace talus::import
{
namespace
{
const Format* format_of_file(const std::string& path)
{
  if (fs::path(path).filename() == kBagDescription) return format_by_ending(".db3");
  std::array<char, 16> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  const std::string_view begin(head.data(), static_cast<std::size_t>(file.gcount()));
  for (const Format& format : kFormats)
    for (const std::string_view mark : format.marks)
      if (begin.substr(0, mark.size()) == mark) return &format;
  return format_by_ending(is_file_of_bag(path) ? io::without_packing(path) : path);
}

/** Whether one of the files of a folder that are not hidden is of that kind. */
template <class Wanted>
bool holds(const fs::path& folder, const Wanted& is_wanted)
{
  std::error_code error, no_file;  // a link to itself is no file, and no error of the folder
  for (fs::directory_iterator i(folder, error), end; !error && i != end; i.increment(error))
    if (i->path().filename().string()[0] != '.' && is_wanted(i->path().string()) &&
        i->is_regular_file(no_file))
      return true;
  return false;
}

bool has_scans(const fs::path& folder)
{
  return holds(
      folder,
      [](const std::string& file)
      {
        const Format* format = format_by_ending(file);
        return format && format->is_scan;
      });
}

/** A recorder that was killed leaves no description. */
bool is_folder_of_bag(const std::string& path)
{
  std::error_code error;
  return fs::exists(fs::path(path) / kBagDescription, error) ||
         (holds(path, is_file_of_bag) && !has_scans(path));
}
}  // namespace

const Format* format_by_ending(const std::string& path)
{
  const std::string name = lower_case(path);
  for (const Format& format : kFormats)
    for (const std::string_view ending : format.endings)
      if (ends_with(name, ending)) return &format;
  return nullptr;
}

bool is_file_of_bag(const std::string& path)
{
  const Format* format = format_by_ending(io::without_packing(path));
  return format && format->open;
}

std::string endings_of_scans()
{
  std::vector<std::string_view> endings;
  for (const Format& format : kFormats)
    if (format.read) endings.insert(endings.end(), format.endings.begin(), format.endings.end());
  std::string text;
  for (std::size_t i = 0; i < endings.size(); ++i)
    text.append(i == 0 ? "" : i + 1 < endings.size() ? ", " : " or ").append(endings[i]);
  return text;
}

std::string folder_with_scans(const std::string& path)
{
  const fs::path folder(path);
  for (const fs::path& inner :
       {fs::path(), fs::path("velodyne"), fs::path("velodyne_points") / "data", fs::path("data")})
    if (const fs::path candidate = inner.empty() ? folder : folder / inner; has_scans(candidate))
      return candidate.string();
  return "";
}

void refuse_fields(const std::string& path)
{
  throw std::runtime_error(
      path + ": names its fields itself: leave out --fields, which is for .bin files.");
}

Input::Input(const std::string& path) : paths{path}
{
  std::error_code error;
  const auto status = fs::status(path, error);
  if (fs::is_regular_file(status)) format = format_of_file(path);
  if (fs::is_directory(status) && is_folder_of_bag(path)) format = format_by_ending(".db3");
}

bool Input::is_bag() const { return format && format->open; }

std::vector<Input> inputs_of(const std::vector<std::string>& paths)
{
  std::vector<Input> inputs;
  for (const std::string& path : paths)
  {
    Input input(path);
    const auto bag = std::find_if(
        inputs.begin(), inputs.end(),
        [&](const Input& other) { return input.is_bag() && other.is_bag(); });
    if (bag == inputs.end())
      inputs.push_back(std::move(input));
    else
      bag->paths.push_back(path);
  }
  return inputs;
}

std::unique_ptr<ScanSource> open_scan_source(const Input& input, const SourceOptions& options)
{
  const std::string& path = input.paths.front();
  if (!input.is_bag())
    if (auto map = open_whole_map(input, options)) return map;
  if (!input.is_bag()) return place_scans(open_scan_folder(input, options), path, options, false);
  if (!options.fields.empty()) refuse_fields(path);
  return place_scans(input.format->open(input.paths, options), path, options, true);
}

}  // namespace talus::import
