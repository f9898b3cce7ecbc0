#pragma once
#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace talus::import
{
/** A word as it can be printed: short, and without control characters. */
inline std::string shown(std::string_view word)
{
  constexpr std::size_t kLongest = 24;
  std::string out(word.substr(0, kLongest));
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  return "'" + out + (word.size() > kLongest ? "..." : "") + "'";
}

/** Throws std::runtime_error of a file that is damaged there. */
[[noreturn]] inline void fail_at(const std::string& place, const std::string& what)
{
  throw std::runtime_error(place + ": " + what + ". Copy or write it again.");
}

/** The lines of a text one after the other, and the words of the line: separated by blanks. */
class TextLines
{
 public:
  explicit TextLines(std::string_view text) : text_(text) {}

  /** False at the end. */
  bool next_line()
  {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    line_ = rest_ = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    ++number_;
    return true;
  }

  /** The next word of the line; empty at its end. */
  std::string_view next_word()
  {
    const std::size_t begin = std::min(rest_.find_first_not_of(kBlank), rest_.size());
    const std::size_t end = std::min(rest_.find_first_of(kBlank, begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
  }

  std::string_view line() const { return line_; }
  bool is_blank() const { return line_.find_first_not_of(kBlank) == std::string_view::npos; }
  std::size_t line_number() const { return number_; }
  /** Where the next line begins [bytes]. */
  std::size_t position() const { return at_; }

 private:
  static constexpr std::string_view kBlank = " \t\r\v\f";
  std::string_view text_, line_, rest_;
  std::size_t at_ = 0, number_ = 0;
};

}  // namespace talus::import
