#pragma once
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>

namespace talus::import
{
/** A file that is read, and what was written over it. */
class CoveredFile
{
 public:
  /** A descriptor of its own, or -1: a file that is in memory alone. */
  CoveredFile(int descriptor, std::uint64_t stored, std::uint64_t size)
      : descriptor_(descriptor), stored_(stored), size_(size)
  {
  }
  ~CoveredFile()
  {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  CoveredFile(const CoveredFile&) = delete;
  CoveredFile& operator=(const CoveredFile&) = delete;

  std::uint64_t size() const { return size_; }

  /** With zeros behind the end. False: the system fails. */
  bool read(std::uint64_t begin, std::size_t count, char* to) const
  {
    std::memset(to, 0, count);
    if (!read_stored(begin, count, to)) return false;
    for (auto at = blocks_.lower_bound(begin / kBlock); at != blocks_.end(); ++at)
    {
      const std::uint64_t block = at->first * kBlock;
      if (block >= begin + count) break;
      const auto from = std::max(block, begin), end = std::min(block + kBlock, begin + count);
      std::memcpy(to + (from - begin), at->second.data() + (from - block), end - from);
    }
    return true;
  }

  bool write(std::uint64_t begin, std::size_t count, const char* from)
  {
    const std::uint64_t end = begin + count;
    for (std::uint64_t at = begin; at < end;)
    {
      const std::uint64_t number = at / kBlock, offset = at % kBlock;
      const auto part = std::min<std::uint64_t>(kBlock - offset, end - at);
      const auto [block, is_new] = blocks_.try_emplace(number);
      if (is_new && !read_stored(number * kBlock, kBlock, block->second.data())) return false;
      std::memcpy(block->second.data() + offset, from + (at - begin), part);
      at += part;
    }
    size_ = std::max(size_, end);
    return true;
  }

  void truncate(std::uint64_t size)
  {
    size_ = size;
    stored_ = std::min(stored_, size);
    blocks_.erase(blocks_.lower_bound((size + kBlock - 1) / kBlock), blocks_.end());
    const auto last = blocks_.find(size / kBlock);
    if (last != blocks_.end())
      std::fill(
          last->second.begin() + static_cast<std::ptrdiff_t>(size % kBlock), last->second.end(),
          '\0');
  }

 private:
  static constexpr std::uint64_t kBlock = 512;  //!< the smallest page

  bool read_stored(std::uint64_t begin, std::size_t count, char* to) const
  {
    const std::uint64_t end = std::min<std::uint64_t>(begin + count, stored_);
    for (std::uint64_t at = begin; at < end;)
    {
      const auto got = ::pread(descriptor_, to + (at - begin), end - at, static_cast<off_t>(at));
      if (got < 0) return false;
      if (got == 0) break;  // it was cut meanwhile
      at += static_cast<std::uint64_t>(got);
    }
    return true;
  }

  int descriptor_;
  std::uint64_t stored_, size_;
  std::map<std::uint64_t, std::array<char, kBlock>> blocks_;
};

}  // namespace talus::import
