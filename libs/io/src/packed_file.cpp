#include "packed_file.h"

#include <talus/io/atomic_file.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace talus::io
{
namespace
{
constexpr std::size_t kChunk = 1 << 18;
constexpr std::size_t kLong = 1 << 16;  //!< what is read at once goes where it is wanted
constexpr std::size_t kLongestBegin = 4;

constexpr std::uint64_t kNotWorthACheck = std::uint64_t{1} << 30;
}  // namespace

PackedFile::PackedFile(const std::string& path)
    : path_(path), file_(path, std::ios::binary), packed_(kChunk), unpacked_(kChunk)
{
  if (!file_) throw std::runtime_error(path + ": cannot be opened. Check its permissions.");
  std::error_code is_no_file;  // with a size
  const std::uintmax_t size = std::filesystem::file_size(path, is_no_file);
  if (!is_no_file) file_bytes_ = size;
  refill();
  unpacker_ = make_unpacker({rest_.begin, rest_.size});
}

std::size_t PackedFile::read(void* to, std::size_t count)
{
  std::size_t got = 0;
  for (std::size_t n = 1; n > 0 && got < count; got += n)
  {
    char* const at = static_cast<char*>(to) + got;
    if (next_ == end_ && count - got >= kLong)
      n = unpack({at, count - got});
    else if (next_ == end_ && !unpack_more())
      n = 0;
    else
    {
      n = std::min(count - got, end_ - next_);
      std::memcpy(at, unpacked_.data() + next_, n);
      next_ += n;
    }
  }
  position_ += got;
  return got;
}

double PackedFile::progress() const
{
  const std::uint64_t taken_bytes = fetched_bytes_ - rest_.size;
  const double of_last = end_ == 0 ? 1 : static_cast<double>(next_) / static_cast<double>(end_);
  const double read_bytes = static_cast<double>(before_last_bytes_) +
                            of_last * static_cast<double>(taken_bytes - before_last_bytes_);
  return read_bytes / static_cast<double>(std::max(file_bytes_, taken_bytes));
}

/** What is left moves to the front, so that the beginning of a member is never torn. */
void PackedFile::refill()
{
  if (rest_.size > 0) std::memmove(packed_.data(), rest_.begin, rest_.size);
  errno = 0;
  file_.clear();  // a file may have grown
  file_.read(packed_.data() + rest_.size, static_cast<std::streamsize>(kChunk - rest_.size));
  if (file_.bad())
    throw std::runtime_error(
        path_ + ": cannot be read (" + std::strerror(errno) + "). Copy it again.");
  const auto fetched = static_cast<std::size_t>(file_.gcount());
  fetched_bytes_ += fetched;
  rest_ = {packed_.data(), rest_.size + fetched};
}

/** False at the end. */
bool PackedFile::unpack_more()
{
  const std::size_t size = unpack({unpacked_.data(), unpacked_.size()});
  if (size == 0) return false;
  next_ = 0;
  end_ = size;
  return true;
}

/** The number of bytes that were put there, 0 at the end. */
std::size_t PackedFile::unpack(Room room)
{
  const std::size_t all = room.size;
  const std::uint64_t before_bytes = fetched_bytes_ - rest_.size;
  while (room.size == all)
  {
    if (rest_.size < kLongestBegin) refill();
    const bool is_between = unpacker_->may_end();
    if (rest_.size == 0 && is_between) return 0;
    const std::size_t before = rest_.size;
    if (is_between && unpacked_bytes_ > 0 && !unpacker_->may_go_on_with({rest_.begin, rest_.size}))
      fail(
          "file goes on after its data, from its byte " + std::to_string(fetched_bytes_ - before) +
          " on, with something else. Copy it again, or cut it there.");
    try
    {
      unpacker_->unpack(rest_, room);
    }
    catch (const std::runtime_error& e)
    {
      fail(
          "data is damaged before its byte " + std::to_string(fetched_bytes_ - rest_.size) + " (" +
          e.what() + "). Copy it again.");
    }
    if (rest_.size == before && room.size == all)
      fail(
          "file is cut short, it ends with byte " + std::to_string(fetched_bytes_) +
          " in the middle of its data. Copy it again.");
  }
  before_last_bytes_ = before_bytes;
  unpacked_bytes_ += all - room.size;
  if (unpacked_bytes_ > kNotWorthACheck && unpacked_bytes_ / kMaxPerByte > fetched_bytes_)
    fail(
        "data unpacks to more than " + std::to_string(kMaxPerByte) +
        " bytes from each of the first " + std::to_string(fetched_bytes_) +
        ". No log does: it is damaged, or made to fill memory. Record it again.");
  return all - room.size;
}

void PackedFile::fail(const std::string& what) const
{
  throw std::runtime_error(path_ + ": " + unpacker_->name() + " " + what);
}

std::uint64_t verified_size(const std::string& path)
{
  PackedFile file(path);
  std::vector<char> chunk(kChunk);
  while (file.read(chunk.data(), chunk.size()) == chunk.size()) continue;
  return file.position();
}

void require_complete_packed(const std::string& path, const std::string& name)
{
  const std::string shown = name.empty() ? path : name;
  std::string reason = "not even its header";
  try
  {
    if (PackedFile(path).is_packed())
    {
      verified_size(path);
      return;
    }
  }
  catch (const std::exception&)
  {
    reason = "not to its end";
  }
  throw std::runtime_error(
      shown + ": could not be written, " + reason + "; is the disk full? Free some space there");
}

}  // namespace talus::io
