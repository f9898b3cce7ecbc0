#include <talus/io/atomic_file.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
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
  const fs::path target =
      fs::is_symlink(path, ec) ? fs::weakly_canonical(path, ec) : fs::path(path);
  return ec ? path : target.string();
}

/** Whether a file lies in a hidden folder of talus, with which all that was left in it goes. */
bool is_hidden_with_its_folder(const fs::path& path)
{
  return std::any_of(
      path.begin(), path.end(),
      [](const fs::path& part) { return part.string().rfind(".talus-", 0) == 0; });
}
}  // namespace

AtomicFile::AtomicFile(const std::string& path) : path_(follow_links(path))
{
  std::error_code ec;
  if (fs::is_directory(path_, ec))
    throw std::runtime_error(
        path_ + ": cannot write this file: a folder has this name; rename it or write elsewhere");
  if (fs::exists(path_, ec) && !fs::is_regular_file(path_, ec))
    throw std::runtime_error(
        path_ +
        ": cannot write this file: a device or a pipe has this name, which the new file "
        "would replace; write elsewhere");
  if (!is_hidden_with_its_folder(path_)) remove_abandoned_files(path_);
  try
  {
    hidden_ = std::make_unique<HiddenFolder>(fs::path(path_).parent_path(), kFilePrefix);
  }
  catch (const std::system_error& e)
  {
    fail(path_, e.code().value());
  }
  temporary_path_ = (hidden_->path() / fs::path(path_).filename()).string();
  const int fd = ::open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) fail(path_, errno);
  ::close(fd);
}

AtomicFile::~AtomicFile() = default;

void AtomicFile::write(std::string_view bytes)
{
  std::FILE* f = std::fopen(temporary_path_.c_str(), "wb");
  if (!f) fail(path_, errno);
  errno = 0;
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), f) == bytes.size();
  int error = errno;
  if (std::fclose(f) != 0)
    error = errno;
  else if (written)
    error = 0;
  if (error != 0 || !written) fail(path_, error != 0 ? error : EIO);
}

void AtomicFile::finish()
{
  const int fd = ::open(temporary_path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(path_, errno);
  struct stat replaced;
  if (::stat(path_.c_str(), &replaced) == 0) ::fchmod(fd, replaced.st_mode & 07777);
  const int synced = ::fsync(fd);
  const int error = errno;
  ::close(fd);
  if (synced != 0 && error != EINVAL) fail(path_, error);
}

void AtomicFile::commit()
{
  finish();
  if (::rename(temporary_path_.c_str(), path_.c_str()) != 0) fail(path_, errno);
  hidden_.reset();
}

void write_file(const std::string& path, std::string_view bytes)
{
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

std::size_t remove_abandoned_files(const std::string& path)
{
  std::size_t count = 0;
  for (const auto& hidden :
       HiddenFolder::all_in(fs::path(follow_links(path)).parent_path(), kFilePrefix))
    count += HiddenFolder::remove_if_abandoned(hidden) ? 1 : 0;
  return count;
}

}  // namespace talus::io
