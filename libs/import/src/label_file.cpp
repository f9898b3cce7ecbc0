#include "label_file.h"

#include <talus/input_file.h>

#include <array>
#include <filesystem>
#include <stdexcept>

#include "point_fields.h"
#include "formats.h"

namespace fs = std::filesystem;

namespace talus::import
{
namespace
{
constexpr std::size_t kLabel_bytes = 4;
constexpr std::uint32_t kLabelBits = 0xffff;  //!< above them: which thing of the class it is

std::string label_file_of(const fs::path& scan)
{
  const std::string name = scan.stem().string() + ".label";
  const fs::path in_folder = fs::absolute(scan).parent_path().parent_path() / "labels" / name;
  std::error_code none;
  return (fs::exists(in_folder, none) ? in_folder : scan.parent_path() / name).string();
}

struct LabelClass
{
  std::uint32_t label, of_class;
};
constexpr std::array<LabelClass, 30> kClassesOfSemanticKitti{
    {{10, 1},  {252, 1}, {11, 2},  {15, 2},  {13, 3},  {16, 3},  {18, 3}, {20, 3},
     {256, 3}, {257, 3}, {258, 3}, {259, 3}, {30, 4},  {254, 4}, {31, 5}, {32, 5},
     {253, 5}, {255, 5}, {40, 6},  {60, 6},  {44, 7},  {48, 8},  {49, 9}, {50, 10},
     {51, 11}, {70, 12}, {71, 13}, {72, 14}, {80, 15}, {81, 15}}};
}  // namespace

std::vector<std::uint32_t> read_labels(const std::string& scan, std::size_t points)
{
  if (points == 0) return {};
  const std::string path = label_file_of(scan);
  const std::string bytes = read_input_file(path, "labels of " + scan, kLargestScan_bytes);
  if (bytes.size() != kLabel_bytes * points)
    throw std::runtime_error(
        path + ": has " + std::to_string(bytes.size()) + " bytes, and the " +
        std::to_string(points) + " points of " + scan + " have " +
        std::to_string(kLabel_bytes * points) + ": give the labels of this scan, 32 bits each.");
  std::vector<std::uint32_t> labels(points);
  const bool swapped = is_big_endian_host();
  for (std::size_t i = 0; i < points; ++i)
    labels[i] = static_cast<std::uint32_t>(
                    number_at(bytes.data() + kLabel_bytes * i, NumberType::UInt32, swapped)) &
                kLabelBits;
  return labels;
}

std::uint32_t class_of_semantickitti(std::uint32_t label)
{
  for (const LabelClass& c : kClassesOfSemanticKitti)
    if (c.label == label) return c.of_class;
  return 0;
}

}  // namespace talus::import
