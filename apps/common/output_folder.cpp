#include "output_folder.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
constexpr const char* kSnapshots = "frames";
constexpr const char* kReplaced = ".replaced";  // in the hidden folder: what was there before

[[noreturn]] void fail(const fs::path& path, const std::string& what)
{
  throw std::runtime_error(
      path.string() + ": " + what + "; give a folder that you may write to with --output");
}

/** frame_NNNNNN.tif or .png */
bool is_snapshot(const fs::path& file)
{
  const std::string stem = file.stem().string(), start = "frame_";
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  return (file.extension() == ".tif" || file.extension() == ".png") &&
         stem.size() >= start.size() + 6 && stem.rfind(start, 0) == 0 &&
         std::all_of(
             stem.begin() + static_cast<std::ptrdiff_t>(start.size()), stem.end(), is_digit);
}

/** Everything below a folder that is not a folder, relative to it; summary.json, which says that a
 * run is complete, comes last. */
std::vector<fs::path> files_below(const fs::path& folder)
{
  const fs::path last = "summary.json";
  std::vector<fs::path> files;
  bool has_last = false;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
  {
    if (entry.is_directory()) continue;
    const fs::path relative = entry.path().lexically_relative(folder);
    if (relative == last)
      has_last = true;
    else
      files.push_back(relative);
  }
  if (has_last) files.push_back(last);
  return files;
}
}  // namespace

OutputFolder::OutputFolder(const std::string& folder)
    : name_(folder), folder_(fs::absolute(folder).lexically_normal())
{
  for (const int s : {SIGXFSZ, SIGPIPE}) std::signal(s, SIG_IGN);
  try
  {
    if (!folder_.has_filename()) folder_ = folder_.parent_path();
    constexpr int kMostTries = 100;
    for (int i = 1; staging_.empty(); ++i) make_staging(i < kMostTries);
  }
  catch (...)
  {
    remove_made_folders();
    throw;
  }
}

/** Makes the folder and the hidden one. With `may_vanish` it gives up without an error where a
 * folder vanishes meanwhile: another run that made it removes it again while it is empty. */
void OutputFolder::make_staging(bool may_vanish)
{
  fs::path so_far;
  for (const auto& part : folder_)
  {
    so_far /= part;
    std::error_code ec;
    const auto status = fs::status(so_far, ec);
    if (fs::is_directory(status)) continue;
    if (fs::exists(status)) fail(so_far, "cannot write results there: this is not a folder");
    if (fs::create_directory(so_far, ec)) made_.push_back(so_far);
    const bool vanished =
        ec == std::errc::no_such_file_or_directory || ec == std::errc::file_exists;
    if (vanished && may_vanish) return;
    if (ec) fail(so_far, "cannot make this folder: " + ec.message());
  }
  std::string name = (folder_ / ".talus-map.XXXXXX").string();
  if (::mkdtemp(name.data()))
    staging_ = name;
  else if (errno != ENOENT || !may_vanish)
    fail(folder_, std::string("cannot write there: ") + std::strerror(errno));
}

OutputFolder::~OutputFolder()
{
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  remove_made_folders();
}

void OutputFolder::remove_made_folders() noexcept
{
  // Only empty folders go.
  std::error_code ec;
  for (auto it = made_.rbegin(); it != made_.rend() && fs::remove(*it, ec); ++it)
  {
  }
}

std::string OutputFolder::told(std::string error) const
{
  for (const std::string& hidden : {(staging_ / kReplaced).string(), staging()})
    for (auto at = error.find(hidden); at != std::string::npos;
         at = error.find(hidden, at + name_.size()))
      error.replace(at, hidden.size(), name_);
  return error;
}

void OutputFolder::replace(const fs::path& relative, Moves& done)
{
  const fs::path from = staging_ / relative, to = folder_ / relative;
  const fs::path aside = staging_ / kReplaced / relative;
  fs::create_directories(to.parent_path());
  if (fs::is_directory(to))
    throw std::runtime_error(
        to.string() + ": cannot be replaced, a folder has this name; rename it or write elsewhere");
  const auto status = fs::symlink_status(to);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_symlink(status))
    throw std::runtime_error(
        to.string() + ": cannot be replaced, it is a device or a pipe; write elsewhere");
  if (fs::exists(status))
  {
    fs::create_directories(aside.parent_path());
    fs::rename(to, aside);
    done.emplace_back(to, aside);
  }
  fs::rename(from, to);
  done.emplace_back(from, to);
}

/** Snapshots of another run would be taken for those of this one. */
void OutputFolder::set_aside_old_snapshots(Moves& done)
{
  if (!fs::is_directory(folder_ / kSnapshots) || !fs::is_directory(staging_ / kSnapshots)) return;
  std::vector<fs::path> old;
  for (const auto& entry : fs::directory_iterator(folder_ / kSnapshots))
    if (entry.is_regular_file() && is_snapshot(entry.path())) old.push_back(entry.path());
  const fs::path aside = staging_ / kReplaced / kSnapshots;
  fs::create_directories(aside);
  for (const auto& file : old)
  {
    fs::rename(file, aside / file.filename());
    done.emplace_back(file, aside / file.filename());
  }
}

void OutputFolder::commit(const std::function<void()>& last)
{
  Moves done;
  try
  {
    const auto files = files_below(staging_);
    set_aside_old_snapshots(done);
    for (const auto& file : files) replace(file, done);
    if (last) last();
  }
  catch (const std::exception& e)
  {
    std::error_code ignored;
    for (auto it = done.rbegin(); it != done.rend(); ++it)
      fs::rename(it->second, it->first, ignored);
    throw std::runtime_error(told(e.what()));
  }
}

void require_apart(const std::string& output, const std::vector<std::string>& inputs)
{
  for (const std::string& input : inputs)
  {
    std::error_code none;
    if (!input.empty() && fs::equivalent(output, input, none))
      throw std::runtime_error(
          "'" + output + "' would be overwritten, but it is an input; write elsewhere");
  }
}

}  // namespace talus::app
