#include <talus/import/kitti_poses.h>
#include <talus/input_file.h>
#include <talus/number_text.h>

#include <Eigen/Dense>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "text_lines.h"

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
constexpr std::size_t kNumbers = 12;
constexpr std::uint64_t kMax_bytes = std::uint64_t{1} << 28;
constexpr const char* kMeaning =
    "The 12 numbers are the rows of a rotation matrix, each with its translation behind it";

[[noreturn]] void fail(const std::string& path, std::size_t line, const std::string& what)
{
  throw std::runtime_error(path + ":" + std::to_string(line) + ": " + what + ". " + kMeaning + ".");
}

/** The rest of a line as a pose. */
CPose3D read_pose(const std::string& path, TextLines& lines)
{
  std::array<double, kNumbers> v{};
  for (std::size_t i = 0; i < kNumbers; ++i)
  {
    const auto word = lines.next_word();
    const auto value = number_from(word);
    if (word.empty())
      fail(path, lines.line_number(), "has " + std::to_string(i) + " numbers instead of 12");
    if (!value || !std::isfinite(*value))
      fail(path, lines.line_number(), shown(word) + " is not a number");
    v[i] = *value;
  }
  if (!lines.next_word().empty()) fail(path, lines.line_number(), "has more than 12 numbers");
  mrpt::math::CMatrixDouble33 R;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) R(r, c) = v[static_cast<std::size_t>(4 * r + c)];
  constexpr double kRounded = 0.01;  // two digits a number are enough
  const double error =
      (R.asEigen() * R.asEigen().transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kRounded) || !(R.asEigen().determinant() > 0))
    fail(path, lines.line_number(), "has no rotation matrix");
  return CPose3D(R, mrpt::math::CMatrixDouble31({v[3], v[7], v[11]}));
}

std::size_t count_words(TextLines lines)
{
  std::size_t words = 0;
  while (!lines.next_word().empty()) ++words;
  return words;
}

/** The number of the frame at the beginning of a line of KITTI-360. */
std::size_t read_frame(const std::string& path, TextLines& lines)
{
  const auto word = lines.next_word();
  std::size_t frame = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), frame);
  if (error != std::errc() || end != word.data() + word.size())
    fail(path, lines.line_number(), shown(word) + " is not the number of a frame");
  return frame;
}
}  // namespace

bool is_kitti_poses(const std::string& path)
{
  require_readable_file(path, "trajectory");
  constexpr std::size_t kEnough_bytes = 4096;
  std::string text(kEnough_bytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  TextLines lines(std::string_view(text).substr(0, static_cast<std::size_t>(file.gcount())));
  while (lines.next_line())
  {
    std::size_t words = 0;
    for (auto word = lines.next_word(); !word.empty(); word = lines.next_word(), ++words)
      if (!number_from(word)) break;
    if (lines.is_blank()) continue;
    if (lines.line()[0] != '#') return words == kNumbers || words == kNumbers + 1;
  }
  return false;
}

KittiPoses read_kitti_poses(const std::string& path)
{
  const std::string text = read_input_file(path, "list of poses", kMax_bytes);
  TextLines lines(text);
  KittiPoses all;
  while (lines.next_line())
  {
    if (lines.is_blank() || lines.line()[0] == '#') continue;
    if (all.poses.empty() ? count_words(lines) == kNumbers + 1 : !all.frames.empty())
      all.frames.push_back(read_frame(path, lines));
    all.poses.push_back(read_pose(path, lines));
  }
  return all;
}

CPose3D read_kitti_calibration(const std::string& path)
{
  const std::string text = read_input_file(path, "calibration", kMax_bytes);
  TextLines lines(text);
  while (lines.next_line())
  {
    const auto key = lines.next_word();
    for (const char* known : {"Tr:", "Tr_velo_to_cam:", "Tr_velo_cam:"})
      if (key == known) return read_pose(path, lines);
  }
  throw std::runtime_error(
      path +
      ": has no line 'Tr:' with the place of the scanner before the camera. Take the "
      "calib.txt that comes with KITTI's velodyne scans.");
}

CPose3D read_kitti_360_calibration(const std::string& folder)
{
  const auto pose_in = [&folder](const char* name, const char* key)
  {
    const std::string path = folder + "/" + name;
    const std::string text = read_input_file(path, "calibration", kMax_bytes);
    TextLines lines(text);
    while (lines.next_line())
    {
      TextLines line = lines;
      if (key && line.next_word() != key) continue;
      return read_pose(path, line);
    }
    throw std::runtime_error(
        path + ": has no line '" + (key ? key : "R t") +
        "'. Take the one that comes with KITTI-360.");
  };
  const CPose3D T_pose_camera = pose_in("calib_cam_to_pose.txt", "image_00:"),
                T_scanner_camera = pose_in("calib_cam_to_velo.txt", nullptr);
  return T_pose_camera + (-T_scanner_camera);
}

}  // namespace talus::import
