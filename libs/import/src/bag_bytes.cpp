#include "bag_bytes.h"

#include <talus/input_file.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace talus::import
{
namespace
{
constexpr std::size_t kWindow = std::size_t{1} << 16;
constexpr std::size_t kStep = std::size_t{1} << 14;  //!< of one look: not all that is skipped
}  // namespace

std::string_view RecordReader::take(std::uint64_t bytes)
{
  if (bytes > rest_.size()) throw std::runtime_error("is cut short");
  const auto taken = rest_.substr(0, bytes);
  rest_.remove_prefix(bytes);
  return taken;
}

std::uint64_t RecordReader::number(std::size_t bytes)
{
  std::uint64_t value = 0;
  const auto at = take(bytes);
  for (std::size_t i = 0; i < bytes; ++i)
    value |= std::uint64_t{static_cast<unsigned char>(at[i])} << (8 * i);
  return value;
}

FileBytes::FileBytes(const std::string& path) : path_(path)
{
  require_readable_file(path, "bag");
  size_ = std::filesystem::file_size(path);
}

std::string_view FileBytes::look(std::uint64_t begin, std::size_t most)
{
  most = std::min(most, kWindow);
  if (begin >= size_) return {};
  most = static_cast<std::size_t>(std::min<std::uint64_t>(most, size_ - begin));
  const bool is_there = begin >= window_begin_ && begin + most <= window_begin_ + window_.size();
  if (!is_there)
  {
    const auto wanted = std::min<std::uint64_t>(std::max(most, kStep), size_ - begin);
    window_.resize(static_cast<std::size_t>(wanted));
    window_.resize(fill(begin, window_.size(), window_.data()));
    window_begin_ = begin;
  }
  const std::string_view window(window_.data(), window_.size());
  return window.substr(std::min<std::size_t>(begin - window_begin_, window.size()), most);
}

void FileBytes::read(std::uint64_t begin, std::size_t count, std::vector<char>& out)
{
  out.resize(count);
  if (fill(begin, count, out.data()) != count)
    throw std::runtime_error(
        path_ + ": cannot be read from its byte " + std::to_string(begin) +
        " on. Was it changed meanwhile? Copy it again.");
}

std::size_t FileBytes::fill(std::uint64_t begin, std::size_t count, char* to)
{
  if (!file_.is_open()) file_.open(path_, std::ios::binary);
  file_.clear();
  if (position_ != begin) file_.seekg(static_cast<std::streamoff>(begin));
  file_.read(to, static_cast<std::streamsize>(count));
  const auto got = static_cast<std::size_t>(file_.gcount());
  position_ = begin + got;
  return got;
}

void FileBytes::close()
{
  file_.close();
  position_ = 0;
  window_ = {};
}

}  // namespace talus::import
