#include "point_fields.h"

#include <talus/io/quantile.h>
#include <talus/number_text.h>
#include <talus/text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string_view>

namespace talus::import
{
namespace
{
template <class T>
double as(const char* bytes, bool swapped)
{
  std::array<char, sizeof(T)> own{};
  std::memcpy(own.data(), bytes, sizeof(T));
  if (swapped) std::reverse(own.begin(), own.end());
  T value{};
  std::memcpy(&value, own.data(), sizeof(T));
  return static_cast<double>(value);
}

struct TypeRow
{
  char kind;
  std::size_t bytes;
  double (*read)(const char* bytes, bool swapped);
  const char *name, *long_name;  //!< of PLY
};
/** In the order of NumberType. */
constexpr TypeRow kTypes[] = {
    {'I', 1, as<std::int8_t>, "char", "int8"},    {'U', 1, as<std::uint8_t>, "uchar", "uint8"},
    {'I', 2, as<std::int16_t>, "short", "int16"}, {'U', 2, as<std::uint16_t>, "ushort", "uint16"},
    {'I', 4, as<std::int32_t>, "int", "int32"},   {'U', 4, as<std::uint32_t>, "uint", "uint32"},
    {'F', 4, as<float>, "float", "float32"},      {'F', 8, as<double>, "double", "float64"},
    {'I', 8, as<std::int64_t>, "int64", "long"},  {'U', 8, as<std::uint64_t>, "uint64", "ulong"}};

const TypeRow& row_of(NumberType type) { return kTypes[static_cast<std::size_t>(type)]; }

template <class Is>
std::optional<NumberType> first_type(const Is& is)
{
  const auto* const row = std::find_if(std::begin(kTypes), std::end(kTypes), is);
  if (row == std::end(kTypes)) return std::nullopt;
  return static_cast<NumberType>(row - std::begin(kTypes));
}

/** In small letters, and without what CloudCompare puts before the names of its own fields. */
std::string plain_name(const std::string& name)
{
  std::string plain = lower_case(name);
  constexpr std::string_view kCloudCompare = "scalar_";
  if (plain.compare(0, kCloudCompare.size(), kCloudCompare) == 0)
    plain.erase(0, kCloudCompare.size());
  return plain;
}

using Names = std::vector<std::string_view>;
const Names kIntensity = {"intensity", "i", "reflectivity", "reflectance", "remission"};
const Names kTime = {"t",           "time",     "timestamp", "time_stamp", "stamp",   "point_time",
                     "offset_time", "gps_time", "gpstime",   "dt",         "delta_t", "t_offset"};
const Names kRgb = {"rgb", "rgba"};
const Names kRed = {"red", "r"}, kGreen = {"green", "g"}, kBlue = {"blue", "b"};
constexpr const char* kSeenFrom[] = {"vp_x", "vp_y", "vp_z"};
const Names kRing = {"ring", "channel", "laser_id", "laserid", "line"};

/** The index of the first of the names that there is, or -1. */
int find(const std::vector<PointField>& fields, const Names& names)
{
  for (const auto& name : names)
    for (std::size_t i = 0; i < fields.size(); ++i)
      if (plain_name(fields[i].name) == name) return static_cast<int>(i);
  return -1;
}

constexpr auto kNone = static_cast<std::size_t>(-1);

/** Finite, also as a float. */
bool is_float(double value) { return std::abs(value) <= std::numeric_limits<float>::max(); }

std::string names_of(const std::vector<PointField>& fields)
{
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(fields.size(), 12); ++i)
    names += (names.empty() ? "" : " ") + fields[i].name.substr(0, 24);
  return names.empty() ? "none" : names;
}

using Axis = std::vector<double> ScanFile::*;
constexpr Axis kAxes[] = {&ScanFile::x_m, &ScanFile::y_m, &ScanFile::z_m};

bool has_far_points(const ScanFile& file)
{
  for (const Axis axis : kAxes)
    for (const double value : file.*axis)
      if (std::abs(value) > kWorld_m) return true;
  return false;
}

/** Whole metres in the middle of points in world coordinates; else 0. */
std::array<double, 3> origin_of(const ScanFile& file)
{
  std::array<double, 3> middle_m{};
  if (!has_far_points(file)) return middle_m;
  for (std::size_t i = 0; i < 3; ++i) middle_m[i] = std::round(io::quantile(file.*kAxes[i], 0.5));
  const double far_m = std::hypot(middle_m[0], middle_m[1], middle_m[2]);
  return far_m > kWorld_m ? middle_m : std::array<double, 3>{};
}

/** What floats lose so far away. */
void require_exact(const ScanFile& file, const std::array<double, 3>& origin_m)
{
  constexpr double kMax_m = 0.01;
  float far_m = 0;
  for (const double value : origin_m) far_m = std::max(far_m, static_cast<float>(std::abs(value)));
  const double step_m = std::nextafter(far_m, std::numeric_limits<float>::infinity()) - far_m;
  if (!file.float_coordinates || step_m <= kMax_m) return;
  throw std::runtime_error(
      file.place + ": its points lie " + number_text(std::round(far_m / 1000)) +
      " km from their origin and are floats, which count in steps of " + number_text(step_m, 2) +
      " m there. Write them as doubles, or take an offset off before they are written.");
}
}  // namespace

std::size_t bytes_of(NumberType type) { return row_of(type).bytes; }

double number_at(const char* bytes, NumberType type, bool swapped)
{
  return row_of(type).read(bytes, swapped);
}

std::optional<NumberType> number_type_of(char kind, std::size_t bytes)
{
  return first_type([=](const TypeRow& row) { return row.kind == kind && row.bytes == bytes; });
}

std::optional<NumberType> number_type_named(std::string_view name)
{
  return first_type([=](const TypeRow& row) { return name == row.name || name == row.long_name; });
}

std::size_t bytes_of(const std::vector<PointField>& fields)
{
  std::size_t bytes = 0;
  for (const PointField& f : fields) bytes += bytes_of(f.type) * f.count;
  return bytes;
}

std::vector<FieldPosition> positions_of(
    const std::vector<PointField>& fields, const char* data, std::size_t points, bool swapped,
    bool by_field)
{
  std::vector<FieldPosition> places;
  places.reserve(fields.size());
  const std::size_t point_bytes = bytes_of(fields);
  for (const PointField& f : fields)
  {
    const std::size_t bytes = bytes_of(f.type) * f.count;
    places.push_back({data, by_field ? bytes : point_bytes, swapped});
    data += by_field ? bytes * points : bytes;
  }
  return places;
}

bool is_big_endian_host()
{
  const std::uint16_t one = 1;
  char first = 0;
  std::memcpy(&first, &one, 1);
  return first == 0;
}

PointCollector::PointCollector(
    const std::vector<PointField>& fields, std::size_t points, const std::string& place,
    ScanFile& out)
    : out_(&out)
{
  for (const char* axis : {"x", "y", "z"})
    if (want(fields, {axis}) < 0)
      throw std::runtime_error(
          place + ": its points have no " + axis + " (they have: " + names_of(fields) +
          "). Is it a cloud of points?");
  want_values(fields, place);
  want_times(fields);
  for (std::size_t axis = 0; axis < 3; ++axis) seen_from_[axis] = want(fields, {kSeenFrom[axis]});
  ring_ = want(fields, kRing);
  for (const std::size_t at : wanted_)
    if (fields[at].count != 1)
      throw std::runtime_error(
          place + ": its field '" + fields[at].name.substr(0, 24) + "' has " +
          std::to_string(fields[at].count) +
          " numbers a point instead of one. Write the cloud again, each number as a field.");
  for (std::size_t i = 0; i < fields.size(); ++i)
  {
    const auto at = std::find(wanted_.begin(), wanted_.end(), i);
    columns_.push_back(
        at == wanted_.end() ? kNone : static_cast<std::size_t>(at - wanted_.begin()));
    columns_.resize(columns_.size() + fields[i].count - 1, kNone);
  }
  values_.resize(wanted_.size());
  out.clear();
  out.place = place;
  for (std::size_t axis = 0; axis < 3; ++axis)
    out.float_coordinates |= fields[wanted_[axis]].type == NumberType::Float32;
  for (auto* axis : {&out.x_m, &out.y_m, &out.z_m}) axis->reserve(points);
  if (intensity_ >= 0) out.intensity.reserve(points);
  if (has_rgb()) out.rgb.reserve(points);
  for (auto& time : times_) time.values.reserve(points);
  if (ring_ >= 0) out.ring.reserve(points);
  if (has_seen_from()) out.seen_from_m.reserve(points);
}

/** The index in wanted_ of the first of the names that there is, or -1. */
int PointCollector::want(const std::vector<PointField>& fields, const Names& names)
{
  return want_field(fields, find(fields, names), names == kRgb);
}

/** Those with a known name, then those with a name like relative_time, time_offset_ns. */
void PointCollector::want_times(const std::vector<PointField>& fields)
{
  std::vector<int> found;
  for (const auto& name : kTime)
    if (const int at = find(fields, {name}); at >= 0) found.push_back(at);
  for (std::size_t i = 0; i < fields.size(); ++i)
    for (const char* word : {"time", "stamp"})
      if (fields[i].count == 1 && plain_name(fields[i].name).find(word) != std::string::npos)
        found.push_back(static_cast<int>(i));
  for (auto at = found.begin(); at != found.end(); ++at)
    if (std::find(found.begin(), at, *at) == at)
      times_.push_back({want_field(fields, *at, false), {}});
}

int PointCollector::want_field(const std::vector<PointField>& fields, int at, bool is_colour)
{
  if (at < 0) return -1;
  const PointField& field = fields[static_cast<std::size_t>(at)];
  const bool is_packed = is_colour && field.type == NumberType::Float32;
  wanted_.push_back(static_cast<std::size_t>(at));
  types_.push_back(is_packed ? NumberType::UInt32 : field.type);
  return static_cast<int>(wanted_.size() - 1);
}

void PointCollector::want_values(const std::vector<PointField>& fields, const std::string& place)
{
  const std::string& name = out_->values;
  if (name == "rgb")
  {
    rgb_ = want(fields, kRgb);
    if (rgb_ >= 0)
      is_rgb_text_ = types_.back() == NumberType::Float64;
    else
    {
      red_ = want(fields, kRed);
      green_ = want(fields, kGreen);
      blue_ = want(fields, kBlue);
    }
  }
  else
    intensity_ = name.empty() ? want(fields, kIntensity) : want(fields, {name});
  const bool has_all = name == "rgb" ? rgb_ >= 0 || (red_ >= 0 && green_ >= 0 && blue_ >= 0)
                                     : name.empty() || intensity_ >= 0;
  if (!has_all)
    throw std::runtime_error(
        place + ": its points have no '" + name + "' (they have: " + names_of(fields) +
        "). Name a field of them with --values.");
}

std::uint32_t PointCollector::rgb_of(const double* values) const
{
  constexpr std::uint32_t kNoAlpha = 0x00ffffff;
  constexpr double kMax = std::numeric_limits<std::uint32_t>::max();
  if (rgb_ < 0)
  {
    std::uint32_t rgb = 0;
    for (const int at : {red_, green_, blue_})
    {
      const double v = values[at];  // NaN is none
      rgb = rgb << 8 | (v > 0 ? static_cast<std::uint32_t>(std::min(v, 255.0)) : 0U);
    }
    return rgb;
  }
  const double v = values[rgb_];
  if (is_rgb_text_)
  {
    const float as_float = is_float(v) ? static_cast<float>(v) : 0.0F;
    std::uint32_t bits = 0;
    std::memcpy(&bits, &as_float, sizeof bits);
    return bits & kNoAlpha;
  }
  const double whole = v < 0 ? v + kMax + 1 : v;  // of signed integers
  return whole >= 0 && whole <= kMax ? static_cast<std::uint32_t>(whole) & kNoAlpha : 0;
}

bool PointCollector::add_records(
    const std::vector<FieldPosition>& places, std::size_t count, std::size_t most)
{
  for (std::size_t i = 0; i < count; ++i)
  {
    for (std::size_t k = 0; k < values_.size(); ++k)
    {
      const FieldPosition& at = places[wanted_[k]];
      values_[k] = number_at(at.first + i * at.step, types_[k], at.swapped);
    }
    add(values_.data());
    if (out_->x_m.size() > most) return false;
  }
  return true;
}

void PointCollector::add_text(TextLines& line, const std::string& place)
{
  for (std::size_t column = 0; column < columns_.size(); ++column)
  {
    const auto word = line.next_word();
    if (word.empty())
      fail_at(
          place,
          "has " + std::to_string(column) + " numbers of " + std::to_string(columns_.size()));
    if (columns_[column] == kNone) continue;
    const auto value = number_from(word);
    if (!value) fail_at(place, shown(word) + " is not a number");
    values_[columns_[column]] = *value;
  }
  add(values_.data());
}

void PointCollector::add(const double* values)
{
  const double scale = out_->scale;
  const double x_m = values[0] * scale, y_m = values[1] * scale, z_m = values[2] * scale;
  if (!is_float(x_m) || !is_float(y_m) || !is_float(z_m))
  {
    ++out_->not_finite;
    return;
  }
  for (const auto& place : out_->no_return_points)
    if (place == std::array<double, 3>{x_m, y_m, z_m}) return void(++out_->no_returns);
  out_->x_m.push_back(x_m);
  out_->y_m.push_back(y_m);
  out_->z_m.push_back(z_m);
  for (auto& time : times_) time.values.push_back(values[time.at]);
  if (intensity_ >= 0)
  {
    const double intensity = values[intensity_];
    out_->intensity.push_back(is_float(intensity) ? static_cast<float>(intensity) : 0.0F);
  }
  if (has_rgb()) out_->rgb.push_back(rgb_of(values));
  if (has_seen_from())
    out_->seen_from_m.push_back(
        {scale * values[seen_from_[0]], scale * values[seen_from_[1]],
         scale * values[seen_from_[2]]});
  if (ring_ >= 0)
  {
    constexpr double kMax = std::numeric_limits<std::uint16_t>::max();
    const double ring = values[ring_];  // NaN is none
    out_->ring.push_back(ring >= 0 && ring <= kMax ? static_cast<std::uint16_t>(ring) : 0);
  }
}

/** A time that is the same for all points is that of the scan, where another field has others. */
void PointCollector::finish()
{
  if (times_.empty()) return;
  const auto is_finite = [](double time) { return std::isfinite(time); };
  const auto varies = [&](const TimeField& time)
  {
    const auto& all = time.values;
    const auto first = std::find_if(all.begin(), all.end(), is_finite);
    return std::any_of(first, all.end(), [&](double t) { return is_finite(t) && t != *first; });
  };
  const auto best = std::find_if(times_.begin(), times_.end(), varies);
  auto& time = out_->time;
  time.swap((best == times_.end() ? times_.front() : *best).values);
  std::vector<bool> is_kept(time.size());
  std::transform(time.begin(), time.end(), is_kept.begin(), is_finite);
  const auto kept = std::count(is_kept.begin(), is_kept.end(), true);
  if (kept == 0) return std::fill(time.begin(), time.end(), 0.0);  // none was ever written
  out_->not_finite += time.size() - static_cast<std::size_t>(kept);
  if (static_cast<std::size_t>(kept) < time.size()) out_->keep(is_kept);
}

void ScanFile::keep(const std::vector<bool>& is_kept)
{
  const auto keep_in = [&](auto& all)
  {
    if (all.empty()) return;
    std::size_t i = 0;
    all.erase(
        std::remove_if(all.begin(), all.end(), [&](const auto&) { return !is_kept[i++]; }),
        all.end());
  };
  for (auto* all : {&x_m, &y_m, &z_m, &time}) keep_in(*all);
  keep_in(intensity), keep_in(rgb), keep_in(ring), keep_in(seen_from_m);
}

void take_points(ScanFile& file, ImportedScan& scan)
{
  scan.origin_m = origin_of(file);
  require_exact(file, scan.origin_m);
  std::vector<float>* const axes[] = {&scan.x_m, &scan.y_m, &scan.z_m};
  for (std::size_t i = 0; i < 3; ++i)
  {
    axes[i]->clear();
    axes[i]->reserve((file.*kAxes[i]).size());
    for (const double value : file.*kAxes[i])
      axes[i]->push_back(static_cast<float>(value - scan.origin_m[i]));
  }
  scan.intensity.swap(file.intensity);
  scan.rgb.swap(file.rgb);
  scan.ring.swap(file.ring);
  scan.not_finite = file.not_finite;
}

}  // namespace talus::import
