#include "bag_reader.h"

#include <talus/input_file.h>
#include <talus/io/packed_log.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <system_error>

#include "formats.h"

namespace fs = std::filesystem;

namespace talus::import
{
namespace
{
/** The file of the folder that a line of metadata.yaml means: before Foxy its path began with the
 * folder's name; of one that was packed as a whole, what was unpacked beside. */
fs::path file_named(const fs::path& folder, const std::string& name)
{
  const fs::path stated = fs::path(name).lexically_normal(), beside = folder / stated.filename();
  const bool is_outside = stated.is_absolute() || stated.empty() || *stated.begin() == "..";
  const fs::path path = !is_outside && fs::exists(folder / stated) ? folder / stated : beside;
  const fs::path unpacked = io::without_packing(path.string());
  return fs::exists(unpacked) ? unpacked : path;
}

/** What metadata.yaml states. Throws YAML::Exception where it names no files. */
FilesOfBag description_in(const fs::path& folder)
{
  constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 22;  // takes a hundred times as much
  const auto metadata = (folder / kBagDescription).string();
  const auto text = read_input_file(metadata, "description of a bag", kMaxBytes);
  const auto info = YAML::Load(text)["rosbag2_bagfile_information"];
  FilesOfBag bag;
  for (const auto& name : info["relative_file_paths"].as<std::vector<std::string>>())
    bag.files.push_back(file_named(folder, name).string());
  for (const auto& topic : info["topics_with_message_count"])
    bag.stated[topic["topic_metadata"]["name"].as<std::string>()] +=
        topic["message_count"].as<std::uint64_t>();
  return bag;
}

/** By name, so that the order does not depend on the file system. */
std::vector<std::string> files_in(const fs::path& folder)
{
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
  {
    std::error_code no_file;  // a link to itself is none
    const auto name = entry.path().filename();
    if (name.string()[0] != '.' && is_file_of_bag(name.string()) && entry.is_regular_file(no_file))
      files.push_back(file_named(folder, name.string()).string());
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

std::string listed(const std::vector<std::string>& files)
{
  constexpr std::size_t kMax = 5;
  std::string list;
  for (std::size_t i = 0; i < std::min(files.size(), kMax); ++i)
    list += (list.empty() ? "" : ", ") + fs::path(files[i]).filename().string();
  return files.size() > kMax ? list + " and " + std::to_string(files.size() - kMax) + " more"
                             : list;
}

/** `why`: a clause on metadata.yaml. */
FilesOfBag all_files_in(const fs::path& folder, const std::string& why)
{
  FilesOfBag bag;
  bag.files = files_in(folder);
  if (bag.files.size() > 1)
    bag.remarks.push_back(
        folder.string() + ": " + why + ": its " + std::to_string(bag.files.size()) +
        " files are read as one bag, in the order of recording");
  return bag;
}

/** A description that was broken off while it was written counts as none. */
FilesOfBag described_files(const fs::path& folder)
{
  const fs::path metadata = folder / kBagDescription;
  FilesOfBag bag;
  if (fs::is_regular_file(metadata) && fs::file_size(metadata) == 0)
    return all_files_in(folder, "its metadata.yaml is empty");
  try
  {
    bag = description_in(folder);
  }
  catch (const YAML::Exception&)
  {
    bag.files.clear();
  }
  if (bag.files.empty()) return all_files_in(folder, "its metadata.yaml names no files");
  auto others = files_in(folder);
  const auto is_named = [&](const std::string& file)
  {
    return std::any_of(
        bag.files.begin(), bag.files.end(),
        [&](const std::string& f) { return fs::path(f).filename() == fs::path(file).filename(); });
  };
  others.erase(std::remove_if(others.begin(), others.end(), is_named), others.end());
  if (!others.empty())
    bag.remarks.push_back(
        folder.string() + ": not read, as its metadata.yaml does not name them: " + listed(others) +
        "; without metadata.yaml all files of the folder are read");
  return bag;
}

void require_unpacked(const fs::path& file)
{
  if (io::without_packing(file.string()) == file.string()) return;
  const auto name = file.filename().string(), unpacked = file.stem().string();
  throw std::runtime_error(
      file.string() +
      ": is packed as a whole (rosbag2's compression mode FILE). Unpack it beside: "
      "zstd -d " +
      name + " -o " + unpacked);
}
/** "my_bag_7" begins with "my_bag_", as all parts of that bag do; else empty. */
std::string beginning_of_parts(const fs::path& file)
{
  const auto name = file.stem().string();
  const auto end = name.find_last_not_of("0123456789");
  const bool is_part = end != std::string::npos && end + 1 < name.size() && name[end] == '_';
  return is_part ? name.substr(0, end + 1) : "";
}

/** A part of a bag alone lacks what was recorded once, such as static links of TF. */
FilesOfBag file_alone(const fs::path& file)
{
  FilesOfBag bag;
  bag.files = {file.string()};
  const auto begin = beginning_of_parts(file);
  const auto folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (begin.empty() || !fs::is_directory(folder)) return bag;
  const auto others = files_in(folder);
  const auto parts = std::count_if(
      others.begin(), others.end(),
      [&](const std::string& other) { return beginning_of_parts(other) == begin; });
  if (parts > 1)
    bag.remarks.push_back(
        file.string() + ": is one of " + std::to_string(parts) +
        " parts of a bag; its folder reads them all");
  return bag;
}

FilesOfBag files_of_bag(const std::string& path)
{
  const fs::path given(path);
  const bool is_metadata = given.filename() == kBagDescription;
  if (!is_metadata && !fs::is_directory(given)) return file_alone(given);
  const fs::path folder = is_metadata ? given.parent_path() : given;
  auto bag = is_metadata || fs::exists(folder / kBagDescription)
                 ? described_files(folder.empty() ? "." : folder)
                 : all_files_in(folder, "has no metadata.yaml");
  if (bag.files.empty())
    throw std::runtime_error(path + ": holds no file of a bag (.db3 or .mcap).");
  return bag;
}

/** A recorder that was killed may just have begun its next file. */
void leave_out_empty(FilesOfBag& bag)
{
  std::vector<std::string> filled, empty;
  for (const auto& file : bag.files)
  {
    std::error_code unknown;
    const bool is_empty = fs::is_regular_file(file, unknown) && fs::file_size(file, unknown) == 0;
    (is_empty ? empty : filled).push_back(file);
  }
  if (filled.empty() || empty.empty()) return;
  bag.files = std::move(filled);
  bag.remarks.push_back("left out, as they are empty: " + listed(empty));
}
}  // namespace

FilesOfBag files_of_bags(const std::vector<std::string>& paths)
{
  FilesOfBag all;
  std::set<fs::path> known;
  for (const auto& path : paths)
  {
    auto bag = files_of_bag(path);
    if (paths.size() == 1) all.stated = std::move(bag.stated);  // of all that are read
    for (auto& file : bag.files)
    {
      std::error_code unknown;
      if (known.insert(fs::weakly_canonical(file, unknown)).second)
        all.files.push_back(std::move(file));
    }
    if (paths.size() == 1 || bag.files.size() > 1)
      for (auto& remark : bag.remarks) all.remarks.push_back(std::move(remark));
  }
  for (const auto& file : all.files) require_unpacked(file);
  leave_out_empty(all);
  return all;
}

}  // namespace talus::import
