#include <mrpt/core/Clock.h>
#include <mrpt/poses/CPose3DQuat.h>
#include <talus/input_file.h>
#include <talus/io/rawlog_reader.h>
#include <talus/io/trajectory.h>
#include <talus/number_text.h>
#include <talus/text.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string_view>

using mrpt::poses::CPose3D;

namespace talus::io
{
namespace
{
constexpr const char* kTumColumns = "t x y z qx qy qz qw";

[[noreturn]] void fail_at_line(
    const std::string& path, std::size_t line, const std::string& what, const std::string& remedy)
{
  throw std::runtime_error(path + ":" + std::to_string(line) + ": " + what + ". " + remedy + ".");
}

/** A word as it can be printed: short, and without control characters. */
std::string quoted(std::string_view word)
{
  std::string out(word.substr(0, 24));
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  return "'" + out + (word.size() > 24 ? "..." : "") + "'";
}

/** The words of a line, separated by blanks, up to a comment. */
std::vector<std::string_view> words_of(std::string_view line)
{
  constexpr std::string_view kBlank = " \t\r";
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> words;
  for (auto begin = line.find_first_not_of(kBlank); begin != std::string_view::npos;)
  {
    const auto end = std::min(line.find_first_of(kBlank, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlank, end);
  }
  return words;
}

/** A number as people and programs write it: with a plus sign too, which from_chars() refuses. */
std::from_chars_result read_number(std::string_view word, double& value)
{
  const bool has_plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  return std::from_chars(word.data() + (has_plus ? 1 : 0), word.data() + word.size(), value);
}

/** RTAB-Map writes the number of a pose behind it. */
bool is_id(std::string_view word)
{
  return word.find_first_not_of("0123456789") == std::string_view::npos;
}

/** The eight numbers of a TUM line, in its order. */
std::array<double, 8> parse_numbers(
    const std::vector<std::string_view>& words, const std::string& path, std::size_t line)
{
  const bool is_of_kitti = words.size() == 12 || words.size() == 13;
  if (words.size() != 8 && !(words.size() == 9 && is_id(words.back())))
    fail_at_line(
        path, line, std::to_string(words.size()) + " words instead of the 8 numbers " + kTumColumns,
        is_of_kitti ? "A pose of KITTI has no time, and goes with a folder of scans (talus-map "
                      "FOLDER --poses FILE); for a log or a bag make TUM lines of it, with the "
                      "times of the scans"
                    : "Correct or delete the line; numbers are separated by blanks");
  std::array<double, 8> v{};
  for (std::size_t i = 0; i < v.size(); ++i)
  {
    const char* end = words[i].data() + words[i].size();
    const auto [stop, error] = read_number(words[i], v[i]);
    if (error != std::errc() || stop != end)
      fail_at_line(
          path, line, quoted(words[i]) + " is not a number",
          std::string("TUM lines are ") + kTumColumns + ", separated by blanks");
    if (!std::isfinite(v[i]))
      fail_at_line(path, line, quoted(words[i]) + " is not finite", "Delete lines without a pose");
  }
  return v;
}

struct Quaternion
{
  double r, x, y, z;

  double norm() const { return std::sqrt(x * x + y * y + z * z + r * r); }
  mrpt::math::CQuaternionDouble unit() const
  {
    const double length = norm();
    return {r / length, x / length, y / length, z / length};
  }
};

CPose3D pose_of(const mrpt::math::CQuaternionDouble& unit, double x, double y, double z)
{
  double roll, pitch, yaw;
  unit.rpy(roll, pitch, yaw);
  return CPose3D(x, y, z, yaw, pitch, roll);
}

/** The double that is `steps` doubles above the number. */
double beside(double number, int steps)
{
  for (; steps != 0; steps -= steps > 0 ? 1 : -1)
    number = std::nextafter(number, steps > 0 ? HUGE_VAL : -HUGE_VAL);
  return number;
}

/** That of which pose_of() makes this pose to the last bit: that of MRPT, or one close beside. They
 * have few pitches between them, and those which are wrong are tried once. */
Quaternion quaternion_of(const CPose3D& pose)
{
  constexpr int kMaxSteps = 2;
  const auto mrpt = mrpt::poses::CPose3DQuat(pose).quat();
  const Quaternion q{mrpt.r(), mrpt.x(), mrpt.y(), mrpt.z()};
  const auto& R = pose.getRotationMatrix();
  std::vector<double> wrong;  // half the sine of each
  for (int max = 0; max <= kMaxSteps; ++max)
    for (int w = -max; w <= max; ++w)
      for (int x = -max; x <= max; ++x)
        for (int y = -max; y <= max; ++y)
          for (int z = -max; z <= max; ++z)
          {
            const Quaternion near{beside(q.r, w), beside(q.x, x), beside(q.y, y), beside(q.z, z)};
            const auto unit = near.unit();
            const double sine = unit.r() * unit.y() - unit.x() * unit.z();
            if (std::find(wrong.begin(), wrong.end(), sine) != wrong.end()) continue;
            const auto tried = pose_of(unit, 0, 0, 0).getRotationMatrix();
            if (tried == R) return near;
            if (tried(2, 0) != R(2, 0)) wrong.push_back(sine);
          }
  return q;
}

Trajectory::Entry parse_line(
    const std::vector<std::string_view>& words, const std::string& path, std::size_t line)
{
  const auto v = parse_numbers(words, path, line);
  constexpr double kLatestStamp_s = 1e11;
  if (std::abs(v[0]) > kLatestStamp_s)
    fail_at_line(
        path, line, "time stamp " + quoted(words[0]) + " is far too large for seconds",
        "Convert milli-, micro- or nanoseconds to seconds");

  const Quaternion q{v[7], v[4], v[5], v[6]};
  const double norm = q.norm();
  constexpr double kNormTolerance = 0.05;  // two digits a number are enough to stay inside
  if (std::abs(norm - 1) > kNormTolerance)
    fail_at_line(
        path, line, "quaternion has norm " + std::to_string(norm) + " instead of 1",
        std::string("Check the columns: ") + kTumColumns);
  return {v[0], pose_of(q.unit(), v[1], v[2], v[3])};
}

struct TumLine
{
  std::size_t number;
  Trajectory::Entry entry;
};

/** Stamps may have been rounded: two poses of one time may then differ by what a robot moves in
 * that. */
bool is_same_pose(const CPose3D& a, const CPose3D& b)
{
  constexpr double kMax_m = 0.05, kMax_rad = 0.02;
  const CPose3D difference = b - a;
  mrpt::math::CQuaternionDouble q;
  difference.getAsQuaternion(q);
  return difference.norm() <= kMax_m && 2 * std::acos(std::min(1.0, std::abs(q.r()))) <= kMax_rad;
}

/** Refuses two poses at one time: which of them holds is anybody's guess. */
void require_one_pose_a_time(std::vector<TumLine> lines, const std::string& path)
{
  std::stable_sort(
      lines.begin(), lines.end(),
      [](const TumLine& a, const TumLine& b) { return a.entry.time_s < b.entry.time_s; });
  for (std::size_t i = 1; i < lines.size(); ++i)
  {
    const auto& [first_line, first] = lines[i - 1];
    const auto& [line, entry] = lines[i];
    if (first.time_s == entry.time_s && !is_same_pose(first.T_map_base, entry.T_map_base))
      fail_at_line(
          path, line,
          "another pose than line " + std::to_string(first_line) + " has at the same time",
          std::fmod(entry.time_s, 10) == 0
              ? "The times have lost digits: write them with six decimals (1700000000.123456)"
              : "Delete one of them");
  }
}

/** The next line, as std::getline() gives it, but no longer one than a comment may be: a file of
 * another kind may have no end of a line at all. */
bool next_line(std::istream& file, std::string& text, const std::string& path, std::size_t line)
{
  constexpr std::size_t kLongest = 1 << 16;
  text.clear();
  for (int c = file.get(); c != '\n'; c = file.get())
  {
    if (c == std::char_traits<char>::eof()) return !text.empty();
    text += static_cast<char>(c);
    if (text.size() > kLongest)
      fail_at_line(
          path, line, "no end of the line within 65536 bytes: this is no text file",
          std::string("TUM lines are ") + kTumColumns + ", separated by blanks");
  }
  return true;
}

std::vector<TumLine> read_tum_lines(const std::string& path)
{
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // of editors on Windows
  std::ifstream file(path);
  std::vector<TumLine> lines;
  std::string text;
  for (std::size_t line = 1; next_line(file, text, path, line); ++line)
  {
    std::string_view rest = text;
    if (line == 1 && rest.substr(0, 3) == kByteOrderMark) rest.remove_prefix(3);
    const auto words = words_of(rest);
    if (!words.empty()) lines.push_back({line, parse_line(words, path, line)});
  }
  if (file.bad()) throw std::runtime_error(path + ": cannot be read to its end. Copy it again.");
  return lines;
}

std::vector<Trajectory::Entry> load_tum(const std::string& path)
{
  const auto lines = read_tum_lines(path);
  if (lines.empty())
    throw std::runtime_error(path + ": holds no poses. One a line is needed: " + kTumColumns + ".");
  require_one_pose_a_time(lines, path);
  std::vector<Trajectory::Entry> entries;
  entries.reserve(lines.size());
  for (const auto& line : lines) entries.push_back(line.entry);
  return entries;
}

}  // namespace

std::string tum_line(const Trajectory::Entry& entry)
{
  const auto& p = entry.T_map_base;
  const Quaternion q = quaternion_of(p);
  std::string text =
      exact_number_text(mrpt::Clock::toDouble(mrpt::Clock::fromDouble(entry.time_s)));
  for (const double number : {p.x(), p.y(), p.z(), q.x, q.y, q.z, q.r})
    text += " " + exact_number_text(number);
  return text + "\n";
}

Trajectory::Entry as_in_tum(const Trajectory::Entry& entry)
{
  const std::string line = tum_line(entry);
  return parse_line(words_of(std::string_view(line).substr(0, line.size() - 1)), "", 1);
}

Trajectory Trajectory::load(const std::string& path)
{
  require_readable_file(path, "trajectory");
  const bool is_map = ends_with(path, ".simplemap") || ends_with(path, ".simplemap.gz");
  return is_map ? trajectory_from_rawlog(path) : Trajectory(load_tum(path));
}

}  // namespace talus::io
