#include <talus/number_text.h>
#include <talus/parameters.h>
#include <talus/text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace talus
{
namespace
{
constexpr double kHuge = 1e6;

/** One entry of the table; ints go through double unchanged. */
template <auto member>
ParameterInfo entry(
    const char* name, const char* unit, double min, double max, const char* description)
{
  using Value = std::decay_t<decltype(std::declval<Parameters>().*member)>;
  ParameterInfo info{name, unit, min, max, description};
  info.get = [](const Parameters& p) { return static_cast<double>(p.*member); };
  info.set = [](Parameters& p, double v) { p.*member = static_cast<Value>(v); };
  info.is_integer = !std::is_same_v<Value, double>;
  return info;
}
template <auto member, auto to_text, auto from_text>
ParameterInfo text_entry(const char* name, const char* unit, const char* description)
{
  ParameterInfo info{name, unit, 0, 0, description};
  info.get_text = [](const Parameters& p) { return to_text(p.*member); };
  info.set_text = [](Parameters& p, const std::string& text) { p.*member = from_text(text); };
  return info;
}

std::string number(double v) { return number_text(v); }

constexpr const char* kNoBoxes = "none";

std::array<double, 6> numbers_of(const BodyBox& b)
{
  return {b.min_x_m, b.max_x_m, b.min_y_m, b.max_y_m, b.min_z_m, b.max_z_m};
}

std::string box_text(const BodyBox& b)
{
  std::string text;
  for (const double v : numbers_of(b)) text += (text.empty() ? "" : " ") + exact_number_text(v);
  return text;
}

std::string boxes_text(const std::vector<BodyBox>& boxes)
{
  std::string text;
  for (const BodyBox& b : boxes) text += (text.empty() ? "" : ", ") + box_text(b);
  return text.empty() ? kNoBoxes : text;
}

BodyBox box_from(const std::string& text)
{
  std::vector<double> numbers;
  bool sound = true;
  for (const std::string& piece : pieces_of(text, " \t"))
  {
    if (piece.empty()) continue;
    const auto value = number_from(piece);
    sound = sound && value;
    numbers.push_back(value.value_or(0));
  }
  if (!sound || numbers.size() != 6)
    throw std::invalid_argument(
        "body_boxes_m: '" + text +
        "' is no box: must be six numbers in metres, x_min x_max y_min y_max z_min z_max in the "
        "frame of the robot's base, with a comma before the next box, or none at all: none");
  return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]};
}

void validate_box(const BodyBox& box)
{
  for (std::size_t axis = 0; axis < 3; axis++)
  {
    const double low = numbers_of(box)[2 * axis], high = numbers_of(box)[2 * axis + 1];
    if (!(low >= -kHuge && high <= kHuge))  // also false for NaN
      throw std::invalid_argument(
          "body_boxes_m: the box '" + box_text(box) + "' must lie within " + number(-kHuge) +
          " and " + number(kHuge) + " m");
    if (!(low < high))
      throw std::invalid_argument(
          "body_boxes_m: the box '" + box_text(box) + "' has no extent in " + "xyz"[axis] +
          ": the smaller of the two numbers of each axis goes first");
  }
}

void validate_boxes(const std::vector<BodyBox>& boxes)
{
  if (boxes.size() > kMaxBodyBoxes)
    throw std::invalid_argument(
        "body_boxes_m: " + std::to_string(boxes.size()) + " boxes; " +
        std::to_string(kMaxBodyBoxes) + " are supported at most");
  for (const BodyBox& box : boxes) validate_box(box);
}

std::vector<BodyBox> boxes_from(const std::string& text)
{
  std::vector<BodyBox> boxes;
  if (lower_case(text) == kNoBoxes) return boxes;
  for (const std::string& piece : pieces_of(text, ",")) boxes.push_back(box_from(piece));
  validate_boxes(boxes);
  return boxes;
}

std::string allowed(const ParameterInfo& info)
{
  return "a number from " + number(info.min) + " to " + number(info.max) +
         (*info.unit ? std::string(" ") + info.unit : std::string());
}

std::size_t edit_distance(const std::string& a, const std::string& b)
{
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); i++)
  {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); j++)
    {
      const std::size_t substituted = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

/** People omit the unit: `clearence` is as near to `clearance_m` as to `clearance`. */
std::size_t distance_to_name(const std::string& wanted, const std::string& name)
{
  std::size_t distance = edit_distance(wanted, name);
  for (const std::string unit : {"_m", "_m2", "_rad"})
    if (name.size() > unit.size() && ends_with(name, unit))
      distance =
          std::min(distance, edit_distance(wanted, name.substr(0, name.size() - unit.size())));
  return distance;
}

void validate_voxels(const Parameters& p)
{
  constexpr double kMax = 2147483648.0;  // indices have 32 bits
  if (p.voxel_m == 0 || p.max_range_m / p.voxel_m < kMax) return;
  throw std::invalid_argument(
      "voxel_m = " + number(p.voxel_m) + " m is too small for max_range_m = " +
      number(p.max_range_m) + " m: choose larger voxels or a shorter range");
}

/** Half of the size is counted in pairs of cells: 1 to 16 of them. */
void validate_object_size(const Parameters& p)
{
  const double pairs = std::round(p.object_size_m / (4 * p.resolution_m));
  if (pairs >= 1 && pairs <= 16) return;
  throw std::invalid_argument(
      "object_size_m = " + number(p.object_size_m) + " m is " +
      number(p.object_size_m / p.resolution_m) +
      " cells at resolution_m = " + number(p.resolution_m) +
      " m; 2 to 65 are supported: choose a size from " + number(2 * p.resolution_m) + " to " +
      number(65 * p.resolution_m) + " m or another resolution");
}

bool is_allowed(const ParameterInfo& info, double v)
{
  const bool in_range = v >= info.min && v <= info.max;  // false for NaN
  return in_range && (!info.is_integer || v == std::floor(v));
}

void require_allowed(const ParameterInfo& info, double v)
{
  if (is_allowed(info, v)) return;
  throw std::invalid_argument(
      std::string(info.name) + " = " + number(v) + " is out of range: it must be " + allowed(info));
}

void validate_combinations(const Parameters& p)
{
  const auto fail = [](const std::string& what) { throw std::invalid_argument(what); };
  const double cells = std::round(p.window_m / p.resolution_m);
  if (cells < 4 || cells > kMaxCellsASide)
    fail(
        "window_m = " + number(p.window_m) + " m at resolution_m = " + number(p.resolution_m) +
        " m makes " + number(cells) + " x " + number(cells) + " cells; allowed are 4 to " +
        number(kMaxCellsASide) + " along a side: choose a smaller window or a coarser resolution");
  if (p.min_range_m >= p.max_range_m) fail("min_range_m must be below max_range_m");
  if (p.min_height_m >= p.max_height_m) fail("min_height_m must be below max_height_m");
  if (p.feature_radius_m / p.resolution_m > 15.5)
    fail(
        "feature_radius_m = " + number(p.feature_radius_m) + " m is " +
        number(std::round(p.feature_radius_m / p.resolution_m)) +
        " cells; at most 15 are supported: choose a smaller radius or a coarser resolution");
  validate_boxes(p.body_boxes_m);
  validate_channels(p.channels);
  validate_channel_costs(p.channel_cost, p.channels);
  validate_voxels(p);
  validate_object_size(p);
  const double weights = p.weight_slope + p.weight_step + p.weight_roughness;
  if (std::abs(weights - 1.0) > 1e-6)
    fail("weight_slope + weight_step + weight_roughness must be 1, not " + number(weights));
}

}  // namespace

int Parameters::cells() const { return static_cast<int>(std::lround(window_m / resolution_m)); }

void Parameters::validate() const
{
  for (const auto& info : parameter_table())
    if (!info.is_text()) require_allowed(info, info.get(*this));
  validate_combinations(*this);
}

const std::vector<ParameterInfo>& parameter_table()
{
#define TALUS_NUMBER(type, name, value, unit, min, max, meaning) \
  entry<&Parameters::name>(#name, unit, min, max, meaning),
#define TALUS_TEXT(type, name, to_text, from_text, unit, meaning) \
  text_entry<&Parameters::name, to_text, from_text>(#name, unit, meaning),
  static const std::vector<ParameterInfo> table{TALUS_PARAMETERS(TALUS_NUMBER, TALUS_TEXT)};
  return table;
#undef TALUS_NUMBER
#undef TALUS_TEXT
}

const ParameterInfo* find_parameter(const std::string& name)
{
  for (const auto& info : parameter_table())
    if (lower_case(name) == info.name) return &info;
  return nullptr;
}

bool is_same_value(const ParameterInfo& info, const Parameters& a, const Parameters& b)
{
  return info.is_text() ? info.get_text(a) == info.get_text(b) : info.get(a) == info.get(b);
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& names)
{
  const auto wanted = lower_case(name);
  std::size_t shortest = std::max<std::size_t>(1, wanted.size() / 3) + 1;
  std::string nearest;
  for (const auto& known : names)
    if (const auto distance = distance_to_name(wanted, lower_case(known)); distance < shortest)
    {
      shortest = distance;
      nearest = known;
    }
  return nearest;
}

std::string nearest_parameter_name(const std::string& name)
{
  std::vector<std::string> names;
  names.reserve(parameter_table().size());
  for (const auto& info : parameter_table()) names.emplace_back(info.name);
  return nearest_name(name, names);
}

void set_parameter(Parameters& p, const std::string& name, const std::string& text)
{
  const ParameterInfo* info = find_parameter(name);
  if (!info)
  {
    const std::string nearest = nearest_parameter_name(name);
    throw std::invalid_argument(
        "unknown parameter '" + name + "'; " +
        (nearest.empty() ? "doc/parameters.md lists them all" : "did you mean '" + nearest + "'?"));
  }
  if (info->is_text()) return info->set_text(p, text);
  const auto value = number_from(text);
  if (!value || !is_allowed(*info, *value))
    throw std::invalid_argument(
        std::string(info->name) + " = '" + text + "': must be " + allowed(*info));
  info->set(p, *value);
}

void set_parameter(Parameters& p, const ParameterInfo& info, double value)
{
  if (info.is_text()) throw std::invalid_argument(std::string(info.name) + " is no number");
  require_allowed(info, value);
  info.set(p, value);
}

std::string parameter_text(const Parameters& p, const ParameterInfo& info)
{
  return info.is_text() ? info.get_text(p) : number(info.get(p));
}

}  // namespace talus
