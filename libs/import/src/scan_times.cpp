#include "folder_layout.h"

#include <talus/input_file.h>
#include <talus/number_text.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "text_lines.h"

namespace talus::import
{
namespace
{
constexpr std::uint64_t kMax_bytes = std::uint64_t{1} << 28;

/** Days from 1970-01-01 to a date of the Gregorian calendar. */
double days_since_epoch(int year, int month, int day)
{
  const int y = month <= 2 ? year - 1 : year, m = (month + 9) % 12;  // from March on
  const int leap_days = y / 4 - y / 100 + y / 400;
  return 365.0 * y + leap_days + (m * 306 + 5) / 10 + day - 1 - 719468;
}

/** E.g. "2011-09-26" and "13:02:25.951199337". */
std::optional<double> time_of_date(std::string_view date, std::string_view clock)
{
  if (date.size() != 10 || clock.size() < 8) return std::nullopt;
  const auto number = [](std::string_view text) { return number_from(text).value_or(-1); };
  const std::array<double, 6> parts = {number(date.substr(0, 4)),  number(date.substr(5, 2)),
                                       number(date.substr(8, 2)),  number(clock.substr(0, 2)),
                                       number(clock.substr(3, 2)), number(clock.substr(6))};
  constexpr std::array<double, 6> kMin = {1970, 1, 1, 0, 0, 0}, kMax = {9999, 12, 31, 23, 59, 61};
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (!(parts[i] >= kMin[i] && parts[i] <= kMax[i])) return std::nullopt;
  const double days = days_since_epoch(
      static_cast<int>(parts[0]), static_cast<int>(parts[1]), static_cast<int>(parts[2]));
  return days * 86400 + parts[3] * 3600 + parts[4] * 60 + parts[5];
}

/** E.g. "20110926130225951" or "2011-09-26-13-02-25-951". No time since 1970 has as many digits
 * before a point, and begins with such a year. */
std::optional<double> time_of_compact(const std::string& name)
{
  constexpr std::size_t kSecond = 14;  // digits up to it
  std::string digits;
  for (const char c : name)
    if (c >= '0' && c <= '9')
      digits += c;
    else if (c != '-' && c != '_' && c != '.' && c != ':' && c != 'T')
      return std::nullopt;
  const bool is_whole = digits.size() == kSecond || digits.size() == kSecond + 3;
  if (!is_whole || name.find_first_of("._") == 10) return std::nullopt;
  const auto part = [&](std::size_t first) { return digits.substr(first, 2); };
  return time_of_date(
      digits.substr(0, 4) + "-" + part(4) + "-" + part(6),
      part(8) + ":" + part(10) + ":" + part(12) + "." + digits.substr(kSecond));
}

std::optional<double> time_of_line(TextLines& lines)
{
  const auto first = lines.next_word(), second = lines.next_word();
  return second.empty() ? number_from(first) : time_of_date(first, second);
}

[[noreturn]] void fail(const std::string& path, std::size_t line, const std::string& what)
{
  throw std::runtime_error(path + ":" + std::to_string(line) + ": " + what);
}

std::string name_of(const std::string& scan)
{
  return std::filesystem::path(scan).filename().stem().string();
}
}  // namespace

std::optional<std::size_t> number_of_scan(const std::string& scan)
{
  const std::string name = name_of(scan);
  std::size_t number = 0;
  const char* const end = name.data() + name.size();
  const auto read = std::from_chars(name.data(), end, number);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return number;
}

bool have_lines_by_number(const std::vector<std::string>& scans, std::size_t lines)
{
  return std::all_of(
      scans.begin(), scans.end(),
      [=](const std::string& scan) { return number_of_scan(scan).value_or(lines) < lines; });
}

std::vector<double> read_times(const std::string& path)
{
  const std::string text = read_input_file(path, "list of times", kMax_bytes);
  TextLines lines(text);
  std::vector<double> times_s;
  while (lines.next_line())
  {
    if (lines.is_blank()) continue;
    const auto time_s = time_of_line(lines);
    constexpr double kLatest_s = 1e11;
    if (!time_s || !(std::abs(*time_s) <= kLatest_s))
      fail(
          path, lines.line_number(),
          shown(lines.line()) +
              " is no time. A line is one number, in seconds, or a date as 2011-09-26 "
              "13:02:25.951.");
    if (!times_s.empty() && *time_s <= times_s.back())
      fail(
          path, lines.line_number(),
          "is no later than the line before. Put the times, and the scans, into their order.");
    times_s.push_back(*time_s);
  }
  return times_s;
}

std::vector<std::size_t> lines_of_scans(
    const std::vector<std::string>& scans, std::size_t lines, const std::string& path)
{
  std::vector<std::size_t> numbers, in_order;
  numbers.reserve(scans.size());
  in_order.reserve(scans.size());
  for (const auto& scan : scans)
  {
    if (const auto number = number_of_scan(scan); number && *number < lines)
      numbers.push_back(*number);
    in_order.push_back(in_order.size());
  }
  if (numbers.size() == scans.size()) return numbers;
  if (lines == scans.size()) return in_order;
  throw std::runtime_error(
      path + ": has " + std::to_string(lines) + " lines for " + std::to_string(scans.size()) +
      " scans, whose names are not the numbers of lines, from 0 on (such as " +
      shown(name_of(scans.back())) + "). Give it a line a scan.");
}

std::vector<std::string> numbers_of_names(const std::vector<std::string>& scans)
{
  constexpr std::size_t kSeconds = 10, kNanoseconds = 9;
  constexpr const char* kDigits = "0123456789";
  const std::string first = name_of(scans.front()),
                    word = first.substr(0, std::min(first.size(), first.find_first_of(kDigits)));
  std::vector<std::string> names;
  bool has_lines = false, is_count = true;  // of nanoseconds: none begins with a zero, but 0
  std::size_t longest = 0;
  for (const auto& scan : scans)
  {
    names.push_back(name_of(scan));
    std::string& name = names.back();
    if (name.compare(0, word.size(), word) != 0) return {};
    name.erase(0, word.size());
    const auto line = name.find('_');
    has_lines |= line == kSeconds;
    if (line == kSeconds) name[line] = '.';
    const bool is_plain = name.find_first_not_of(".0123456789") == std::string::npos;
    if (!is_plain || !number_from(name)) return {};
    if (name.find('.') != kSeconds) is_count = false;
    const auto fraction = name.substr(std::min(kSeconds + 1, name.size()));
    longest = std::max(longest, fraction.size());
    is_count = is_count && (fraction == "0" || (!fraction.empty() && fraction[0] != '0'));
  }
  if (longest == kNanoseconds && (is_count || has_lines))
    for (auto& name : names)
      name.insert(std::min(kSeconds + 1, name.size()), kSeconds + 1 + longest - name.size(), '0');
  return names;
}

std::vector<double> times_of_names(const std::vector<std::string>& scans)
{
  std::vector<double> times_s;
  times_s.reserve(scans.size());
  const auto numbers = numbers_of_names(scans);
  for (std::size_t i = 0; i < scans.size(); ++i)
  {
    auto time_s = time_of_compact(name_of(scans[i]));
    if (!time_s && numbers.empty()) return {};
    // 1e9 is the year 2001; what is less and has no point may be a number of a scan.
    const double value = time_s ? *time_s : number_from(numbers[i]).value_or(0);
    const bool is_count = !time_s && numbers[i].find('.') == std::string::npos;
    if ((is_count && value < 1e9) || value > 1e19) return {};
    const double unit_s = value >= 1e17 ? 1e-9 : value >= 1e14 ? 1e-6 : value >= 1e11 ? 1e-3 : 1;
    times_s.push_back(value * unit_s);
    if (times_s.size() > 1 && times_s.back() <= times_s[times_s.size() - 2]) return {};
  }
  return times_s;
}

}  // namespace talus::import
