#include <talus/io/atomic_file.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <vector>

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

/** The mode that a plain open() would have given to a new file, or that of the file replaced. */
mode_t wanted_mode(const std::string& path)
{
  struct stat info;
  if (::stat(path.c_str(), &info) == 0) return info.st_mode & 07777;
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0666 & ~mask;
}

std::string follow_links(const std::string& path)
{
  std::error_code ec;
  const fs::path target =
      fs::is_symlink(path, ec) ? fs::weakly_canonical(path, ec) : fs::path(path);
  return ec ? path : target.string();
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
  const fs::path p(path_);
  const std::string ending = p.extension().string();
  const std::string wanted =
      (p.parent_path() / ("." + p.stem().string() + ".XXXXXX" + ending)).string();
  std::vector<char> name(wanted.begin(), wanted.end());
  name.push_back('\0');
  const int fd = ::mkstemps(name.data(), static_cast<int>(ending.size()));
  if (fd < 0) fail(path_, errno);
  ::close(fd);
  temporary_path_ = name.data();
}

AtomicFile::~AtomicFile()
{
  if (!temporary_path_.empty()) ::unlink(temporary_path_.c_str());
}

void AtomicFile::commit()
{
  const int fd = ::open(temporary_path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(path_, errno);
  ::fchmod(fd, wanted_mode(path_));
  const int synced = ::fsync(fd);
  const int error = errno;
  ::close(fd);
  if (synced != 0 && error != EINVAL) fail(path_, error);
  if (::rename(temporary_path_.c_str(), path_.c_str()) != 0) fail(path_, errno);
  temporary_path_.clear();
}

void write_file(const std::string& path, std::string_view bytes)
{
  AtomicFile file(path);
  std::FILE* f = std::fopen(file.temporary_path().c_str(), "wb");
  if (!f) fail(path, errno);
  errno = 0;
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), f) == bytes.size();
  int error = errno;
  if (std::fclose(f) != 0)
    error = errno;
  else if (written)
    error = 0;
  if (error != 0 || !written) fail(path, error != 0 ? error : EIO);
  file.commit();
}

}  // namespace talus::io
