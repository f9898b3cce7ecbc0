#include "output_folder.h"

#include "placing.h"

#include <cerrno>
#include <csignal>
#include <iostream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
void tell(const std::string& folder, const Swept& swept)
{
  const auto say = [&](const std::string& what)
  {
    std::cerr << ::program_invocation_short_name << ": warning: " << folder << ": " << what << "\n";
  };
  if (swept.placed > 0)
    say("a run was killed while its results were put there; they are complete now");
  if (swept.removed > 0) say("removed what a run that was killed had left there");
}
}  // namespace

OutputFolder::OutputFolder(const std::string& folder, std::string option)
    : name_(folder), option_(std::move(option)), folder_(fs::absolute(folder).lexically_normal())
{
  for (const int s : {SIGXFSZ, SIGPIPE}) std::signal(s, SIG_IGN);
  try
  {
    if (!folder_.has_filename()) folder_ = folder_.parent_path();
    constexpr int kMostTries = 100;
    for (int i = 1; !hidden_; ++i) make_folders(i < kMostTries);
  }
  catch (...)
  {
    remove_made_folders();
    throw;
  }
}

void OutputFolder::fail(const fs::path& path, const std::string& what) const
{
  throw std::runtime_error(
      path.string() + ": " + what + "; give a folder that you may write to with " + option_);
}

/** Makes the folder and the hidden one. With `may_vanish` it gives up without an error where a
 * folder vanishes meanwhile: another run that made it removes it again while it is empty. */
void OutputFolder::make_folders(bool may_vanish)
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
  try
  {
    const io::FolderLock lock(folder_, io::FolderLock::IfTaken::Wait);
    sweep_and_tell();
    hidden_ = std::make_unique<io::HiddenFolder>(folder_, kRunPrefix);
  }
  catch (const std::system_error& e)
  {
    if (e.code() != std::errc::no_such_file_or_directory || !may_vanish)
      fail(folder_, "cannot write there: " + e.code().message());
  }
}

OutputFolder::~OutputFolder()
{
  elsewhere_.reset();
  hidden_.reset();
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

/** Needs the lock of the folder. */
void OutputFolder::sweep_and_tell() { tell(name_, sweep(folder_)); }

io::AtomicFile& OutputFolder::elsewhere(const std::string& path)
{
  tell(fs::absolute(path).parent_path().string(), {io::remove_abandoned_files(path), 0});
  elsewhere_ = std::make_unique<io::AtomicFile>(path);
  link_elsewhere(hidden_->path(), elsewhere_->hidden_folder());
  return *elsewhere_;
}

std::string OutputFolder::told(std::string error) const
{
  for (const std::string& hidden : {replaced_in(hidden_->path()).string(), staging()})
    for (auto at = error.find(hidden); at != std::string::npos;
         at = error.find(hidden, at + name_.size()))
      error.replace(at, hidden.size(), name_);
  return error;
}

void OutputFolder::commit(const std::string& seal)
{
  const io::FolderLock lock(folder_, io::FolderLock::IfTaken::Wait);
  Moves done;
  try
  {
    if (elsewhere_) elsewhere_->finish();
    sweep_and_tell();
    begin_placing(hidden_->path(), seal, done);
    place(hidden_->path(), done);
  }
  catch (const std::exception& e)
  {
    done.undo();
    throw std::runtime_error(told(e.what()));
  }
}

bool is_same_file(const fs::path& a, const fs::path& b)
{
  std::error_code ec;
  return fs::equivalent(a, b, ec) ||
         fs::weakly_canonical(fs::absolute(a), ec) == fs::weakly_canonical(fs::absolute(b), ec);
}

void require_apart(const std::string& output, const std::vector<std::string>& inputs)
{
  for (const std::string& input : inputs)
    if (!input.empty() && is_same_file(output, input))
      throw std::runtime_error(
          "'" + output + "' would be overwritten, but it is an input; write elsewhere");
}

void require_results_apart(
    const std::string& folder, const std::vector<std::string>& names,
    const std::vector<std::string>& inputs)
{
  for (const std::string& name : names) require_apart((fs::path(folder) / name).string(), inputs);
}

}  // namespace talus::app
