#include <talus/io/atomic_file.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <sys/file.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::io
{
namespace
{
[[noreturn]] void fail(const std::string& path, int error)
{
  std::string hint;
  if (error == ENOSPC || error == EDQUOT)
    hint = "; free some space there";
  else if (error == EACCES || error == EPERM || error == EROFS)
    hint = "; choose a folder that you may write to";
  else if (error == ENOENT)
    hint = "; does its folder exist?";
  throw std::runtime_error(path + ": cannot write this file: " + std::strerror(error) + hint);
}

std::string follow_links(const std::string& path)
{
  std::error_code ec;
  return fs::is_symlink(path, ec) ? fs::weakly_canonical(path).string() : path;
}
}  // namespace

AtomicFile::AtomicFile(const std::string& path) : path_(follow_links(path))
{
  require_replaceable(path_);
  const fs::path folder = fs::path(path_).parent_path();
  const bool is_in_hidden = path_.find("/.talus-") != std::string::npos;  // which goes as a whole
  if (!is_in_hidden) HiddenFolder::remove_abandoned(folder, kFilePrefix);
  try
  {
    hidden_ = std::make_unique<HiddenFolder>(folder, kFilePrefix);
  }
  catch (const std::system_error& e)
  {
    fail(path_, e.code().value());
  }
  temporary_path_ = (hidden_->path() / fs::path(path_).filename()).string();
}

void AtomicFile::write(std::string_view bytes)
{
  errno = 0;
  std::FILE* f = std::fopen(temporary_path_.c_str(), "ab");
  const bool written = f && std::fwrite(bytes.data(), 1, bytes.size(), f) == bytes.size();
  const bool closed = f && std::fclose(f) == 0;
  if (!written || !closed) fail(path_, errno ? errno : EIO);
}

void AtomicFile::commit()
{
  const int fd = ::open(temporary_path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(path_, errno);
  struct stat replaced;
  if (::stat(path_.c_str(), &replaced) == 0) ::fchmod(fd, replaced.st_mode & 07777);
  const bool is_on_disk = ::fsync(fd) == 0 || errno == EINVAL;  // a file system that cannot
  const int error = errno;
  ::close(fd);
  if (!is_on_disk) fail(path_, error);
  if (::rename(temporary_path_.c_str(), path_.c_str()) != 0) fail(path_, errno);
  hidden_.reset();
}

void write_file(const std::string& path, std::string_view bytes)
{
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

void require_replaceable(const std::string& path)
{
  const auto refuse = [&path](const std::string& what)
  {
    throw std::runtime_error(
        path + ": cannot be replaced: " + what + " has this name; rename it or write elsewhere");
  };
  std::error_code ec;
  const auto status = fs::status(path, ec);
  if (fs::is_directory(status)) refuse("a folder");
  if (fs::exists(status) && !fs::is_regular_file(status)) refuse("a device or a pipe");
}

FolderLock::FolderLock(const fs::path& folder, IfTaken if_taken)
    : fd_(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC))
{
  const int how = LOCK_EX | (if_taken == IfTaken::GiveUp ? LOCK_NB : 0);
  do error_ = ::flock(fd_, how) == 0 ? 0 : errno;
  while (error_ == EINTR);
}

FolderLock::~FolderLock()
{
  if (fd_ >= 0) ::close(fd_);
}

bool FolderLock::is_taken() const { return error_ == EWOULDBLOCK; }

HiddenFolder::HiddenFolder(const fs::path& parent, const std::string& prefix)
{
  do
  {
    std::string name = (parent / (prefix + "XXXXXX")).string();
    if (!::mkdtemp(name.data())) throw std::system_error(errno, std::generic_category());
    path_ = name;
    lock_ = std::make_unique<FolderLock>(path_, FolderLock::IfTaken::GiveUp);
    // Before it had its lock, another process may have taken it for one that was left.
  } while (lock_->is_taken() || !fs::exists(path_));
}

HiddenFolder::~HiddenFolder()
{
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<fs::path> HiddenFolder::all_in(const fs::path& parent, const std::string& prefix)
{
  std::vector<fs::path> found;
  std::error_code ec;
  for (fs::directory_iterator it(parent.empty() ? "." : parent, ec), end; !ec && it != end;
       it.increment(ec))
    if (std::error_code gone; it->path().filename().string().rfind(prefix, 0) == 0 &&
                              fs::is_directory(it->symlink_status(gone)))
      found.push_back(it->path());
  return found;
}

std::size_t HiddenFolder::remove_abandoned(const fs::path& parent, const std::string& prefix)
{
  std::size_t count = 0;
  for (const fs::path& hidden : all_in(parent, prefix))
  {
    const FolderLock lock(hidden, FolderLock::IfTaken::GiveUp);
    std::error_code ec;
    if (lock.is_held() && fs::remove_all(hidden, ec) > 0 && !ec) ++count;
  }
  return count;
}

}  // namespace talus::io
