#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/system/string_utils.h>
#include <talus/mrpt/parameters_ini.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "ini_sections.h"

namespace talus
{
namespace
{
using mrpt::system::lowerCase;
using mrpt::system::trim;

/** A line as MRPT takes it: a backslash at its end joins the next one to it. */
struct Line
{
  int number = 1;  //!< where it begins
  std::string text;
  std::size_t joined_at = 0;  //!< in the text, the last time
};

bool ends_line(char c) { return c == '\n' || c == '\r'; }

/** Without `@define NAME VALUE`, which MRPT takes out wherever it stands. */
std::vector<Line> lines_of(const std::string& text)
{
  const std::string mark = "\xef\xbb\xbf";  // of UTF-8
  std::vector<Line> lines(1);
  int number = 1;
  for (std::size_t i = text.compare(0, mark.size(), mark) == 0 ? mark.size() : 0; i < text.size();
       ++i)
  {
    if (text.compare(i, 7, "@define") == 0)
      i = std::min(text.find_first_of("\r\n", i), text.size());
    const bool joins = text[i] == '\\' && ends_line(text[i + 1]);
    if (joins) ++i;
    if (i == text.size()) break;
    if (!ends_line(text[i]))
    {
      lines.back().text += text[i];
      continue;
    }
    if (text[i] == '\r' && text[i + 1] == '\n') ++i;
    ++number;
    if (joins)
      lines.back().joined_at = lines.back().text.size();
    else
      lines.push_back({number, {}, 0});
  }
  return lines;
}

/** For a message: short, without what a terminal would obey, and without the brackets at the first
 * pair of which MRPT cuts what it prints of an exception. */
std::string quoted(const std::string& text)
{
  constexpr std::size_t kLongest = 60;
  const auto end = std::find_if(
      text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) || c == '['; });
  std::string shown(text.begin(), end);
  if (shown.size() > kLongest) shown.resize(kLongest);
  return "'" + shown + (shown.size() < text.size() ? "..." : "") + "'";
}

/** Reads the lines of a text one after the other and throws what is wrong with one. */
class LineCheck
{
 public:
  LineCheck(std::string file, const std::vector<std::string>& sections) : file_(std::move(file))
  {
    for (const auto& s : sections) own_.push_back(lowerCase(s));
  }

  void take(const Line& line)
  {
    number_ = line.number;
    if (line.text.find('\0') != std::string::npos)
      fail("a NUL byte, behind which nothing is read; save the file as plain text (UTF-8)");
    const auto comment = detail::comment_begin(line.text);
    const std::string text = trim(line.text);
    if (!text.empty() && text.front() == '[') return take_header(text);
    if (!is_own_) return;
    if (comment < line.joined_at)
      fail("a comment that ends in a backslash swallows the next line; remove the backslash");
    take_key(trim(line.text.substr(0, comment)));
  }

 private:
  [[noreturn]] void fail(const std::string& what) const
  {
    throw std::runtime_error(file_ + ":" + std::to_string(number_) + ": " + what);
  }

  void take_header(const std::string& text)
  {
    const auto close = std::min(text.find(']'), text.size());
    const bool is_closed = close < text.size();
    const std::string name =
        is_closed ? text.substr(1, close - 1) : text.substr(1, detail::comment_begin(text) - 1);
    section_ = lowerCase(trim(name));
    is_own_ = std::find(own_.begin(), own_.end(), section_) != own_.end();
    if (!is_own_) return;
    if (!is_closed) fail("the name of this section has no closing bracket; add it");
    const std::string behind = text.substr(close + 1);
    if (!trim(behind.substr(0, detail::comment_begin(behind))).empty())
      fail("nothing behind the name of a section is read; put it into a line of its own");
  }

  void take_key(const std::string& text)
  {
    if (text.empty()) return;
    const auto equals = text.find('=');
    if (equals == std::string::npos)
      fail(quoted(text) + " has no '='; write 'name = value', or a ';' before a comment");
    const std::string key = trim(text.substr(0, equals));
    if (key.empty()) fail(quoted(text) + " has no name; write 'name = value'");
    const auto [first, is_new] = lines_of_keys_.emplace(section_ + '\n' + lowerCase(key), number_);
    if (!is_new)
      fail(
          quoted(key) + " is given again, first in line " + std::to_string(first->second) +
          "; leave one of them");
  }

  std::string file_, section_;
  std::vector<std::string> own_;
  bool is_own_ = false;
  int number_ = 0;
  std::map<std::string, int> lines_of_keys_;
};
}  // namespace

void require_sound_ini(
    const std::string& text, const std::string& file, const std::vector<std::string>& sections)
{
  LineCheck check(file, sections);
  for (const auto& line : lines_of(text)) check.take(line);
}

void require_sound_ini(
    const mrpt::config::CConfigFileBase& cfg, const std::vector<std::string>& sections)
{
  const std::string file = detail::file_of(cfg);
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) return;  // to open a pipe may wait for ever
  const std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  require_sound_ini(text.str(), file, sections);
}

}  // namespace talus
