#include <talus/io/atomic_file.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
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
  std::FILE* f = std::fopen(temporary_path_.c_str(), "wb");
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

}  // namespace talus::io
