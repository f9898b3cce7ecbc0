#pragma once
#include <talus/import/scan_source.h>

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "text_lines.h"

namespace talus::import
{
/** No sensor sees its points so far away: these are world coordinates. Floats count 1 mm here. */
constexpr double kWorld_m = 1e4;

/** A number in a file, in the order of sensor_msgs/msg/PointField. */
enum class NumberType
{
  Int8,
  UInt8,
  Int16,
  UInt16,
  Int32,
  UInt32,
  Float32,
  Float64,
  Int64,
  UInt64
};

std::size_t bytes_of(NumberType type);

/** As .pcd files have it: F, I or U, and its bytes. */
std::optional<NumberType> number_type_of(char kind, std::size_t bytes);
/** As .ply files have it: "uchar", or "uint8". */
std::optional<NumberType> number_type_named(std::string_view name);

/** Files are little-endian unless they say otherwise. */
bool is_big_endian_host();

/** The number at `bytes`, which may lie anywhere; `swapped`: of the other byte order. */
double number_at(const char* bytes, NumberType type, bool swapped);

/** What a file says of its points, by its order: x, y and z, and what else is known by its name. */
struct PointField
{
  std::string name;
  NumberType type = NumberType::Float32;
  std::size_t count = 1;  //!< numbers a point
};

/** Bytes of a point whose fields follow each other. */
std::size_t bytes_of(const std::vector<PointField>& fields);

/** Where the numbers of a field are in bytes. */
struct FieldPosition
{
  const char* first;  //!< of the first point
  std::size_t step;  //!< from one point to the next [bytes]
  bool swapped;  //!< of the other byte order
};

/** Of points whose fields follow each other; `by_field`: all numbers of a field do. */
std::vector<FieldPosition> positions_of(
    const std::vector<PointField>& fields, const char* data, std::size_t points, bool swapped,
    bool by_field = false);

/** A scan as its file has it. */
struct ScanFile
{
  std::string place;  //!< file, or message of a bag
  std::vector<double> x_m, y_m, z_m;  //!< finite, also as floats
  bool float_coordinates = false;  //!< the file has them as floats
  std::vector<float> intensity;  //!< empty, or one a point; so the next ones
  std::vector<std::uint32_t> rgb;  //!< 0x00RRGGBB
  std::vector<double> time;  //!< in the unit and since the moment that the file means
  std::vector<std::uint16_t> ring;
  std::vector<std::array<double, 3>> seen_from_m;  //!< the sensor in the frame of the points
  std::size_t not_finite = 0;  //!< points that are left out
  std::size_t no_returns = 0;  //!< these too: they lie at one of no_return_points
  std::optional<mrpt::poses::CPose3D> viewpoint;  //!< the sensor in the map, where it says so
  std::string values;  //!< set before it is read, see SourceOptions
  std::vector<std::string> fields;  //!< so is this
  double scale = 1;  //!< and this
  std::vector<std::array<double, 3>> no_return_points;  //!< and these

  /** Leaves out the other points. */
  void keep(const std::vector<bool>& is_kept);
  /** Forgets all but what was set before. */
  void clear()
  {
    ScanFile empty;
    empty.values.swap(values);
    empty.fields.swap(fields);
    empty.scale = scale;
    empty.no_return_points.swap(no_return_points);
    *this = std::move(empty);
  }
};

/** Takes the points of one file, field by field. */
class PointCollector
{
 public:
  /** Throws std::runtime_error, `place` and what is wrong, without x, y or z or without the
   * `values` of `out`, and where one of the fields that are needed is not one number a point.
   * `points`: how many there will be at most. */
  PointCollector(
      const std::vector<PointField>& fields, std::size_t points, const std::string& place,
      ScanFile& out);

  /** Of the fields, those that are needed. */
  const std::vector<std::size_t>& wanted() const { return wanted_; }

  /** `count` points, of which each field has its position. False: stops, as these are more points
   * than `most`. */
  bool add_records(
      const std::vector<FieldPosition>& places, std::size_t count,
      std::size_t most = std::numeric_limits<std::size_t>::max());
  /** The point of a line of text. Throws std::runtime_error, the `place` of the line and what is
   * wrong. */
  void add_text(TextLines& line, const std::string& place);
  /** After the last point: chooses its time of several fields, and leaves out points without. */
  void finish();

 private:
  /** One point: a number for each of wanted(). */
  void add(const double* values);
  using Names = std::vector<std::string_view>;
  int want(const std::vector<PointField>& fields, const Names& names);
  void want_times(const std::vector<PointField>& fields);
  int want_field(const std::vector<PointField>& fields, int at, bool is_colour);
  void want_values(const std::vector<PointField>& fields, const std::string& place);
  bool has_seen_from() const
  {
    return seen_from_[0] >= 0 && seen_from_[1] >= 0 && seen_from_[2] >= 0;
  }
  bool has_rgb() const { return rgb_ >= 0 || red_ >= 0; }
  std::uint32_t rgb_of(const double* values) const;

  std::vector<std::size_t> wanted_;
  std::vector<NumberType> types_;  //!< in bytes: colours that are called a float are none
  std::vector<std::size_t> columns_;  //!< of each number of a line, its index in wanted_, or kNone
  std::vector<double> values_;  //!< of one point
  int intensity_ = -1, ring_ = -1;  //!< indices in wanted_
  struct TimeField
  {
    int at;  //!< in wanted_
    std::vector<double> values;
  };
  std::vector<TimeField> times_;  //!< those that may be it, the likeliest first
  int rgb_ = -1, red_ = -1, green_ = -1, blue_ = -1;
  int seen_from_[3] = {-1, -1, -1};
  bool is_rgb_text_ = false;  //!< the bits of a float as decimals
  ScanFile* out_;
};

/** Moves what is the same in both into `scan`: all but times and viewpoint. Points that lie farther
 * away than floats count millimetres get an origin_m beside them. Throws std::runtime_error that
 * names the place where the file has such points as floats: they are rounded already. */
void take_points(ScanFile& file, ImportedScan& scan);

}  // namespace talus::import
