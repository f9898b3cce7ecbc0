#include "saved_map.h"
#include "kernels/cell.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

namespace talus
{
namespace
{
constexpr char kMagic[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '6'};
/** Of states that were saved before: the lowest bit of Cell::footing told something else. */
constexpr char kMagicOfScans[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '5'};
/** Of those before: of one sensor, and without the time of its last frame. */
constexpr char kMagicOfOneSensor[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '4'};
/** Of those before: without the last array of the cells, too. */
constexpr char kMagicWithoutExtent[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '2'};

/** What stands before the sensors and the layers. */
struct Header
{
  char magic[8];
  std::int32_t cells;
  std::int32_t started;
  std::int64_t min_cell_x, min_cell_y;
  double last_stamp_s, reserved_s;
  float offset_m, settled_m;
  double resolution_m;
  float reference_z_m;
  std::uint8_t sensors, flags, drove_through, reserved;
};

/** What stands between the header and the layers for each sensor. */
struct SensorRecord
{
  std::uint64_t number;
  double z_axis[3];
};

/** Header::flags, see kernels::Datum. */
constexpr std::uint8_t kStartsAnew = 1;

enum class Version
{
  Current,
  OfScans,
  OneSensor,
  WithoutExtent
};

constexpr std::size_t kCellFloats = 4, kFeatures = 5;
constexpr double kFarthestCell = 2e9, kHighest_m = 1e9;  //!< beyond what frames can lead to

[[noreturn]] void fail(const std::string& what)
{
  throw std::invalid_argument("saved map: " + what);
}

std::size_t cell_count(const Parameters& p)
{
  const auto n = static_cast<std::size_t>(p.cells());
  return n * n;
}

/** Of a map that has seen a frame. The oldest states are without one array. */
std::size_t cell_bytes(std::size_t cells, Version version)
{
  constexpr std::size_t kNewest = 1;  // arrays that came with several sensors
  switch (version)
  {
    case Version::Current:
    case Version::OfScans:
      return cells * kBytesPerCell;
    case Version::OneSensor:
      return cells * (kBytesPerCell - kNewest);
    default:
      return cells * (kBytesPerCell - kNewest - 1);
  }
}
std::size_t feature_bytes(std::size_t cells) { return kFeatures * cells * sizeof(float); }

bool tells_sensors(Version v) { return v == Version::Current || v == Version::OfScans; }

bool is_within(double v, double limit) { return std::abs(v) <= limit; }  // not NaN

/** Between the header and the end, of a map that has seen a frame. */
std::size_t bytes_behind_header(std::size_t cells, Version version, std::size_t sensors)
{
  const std::size_t of_sensors = tells_sensors(version) ? sensors * sizeof(SensorRecord) : 0;
  return of_sensors + cell_bytes(cells, version) + feature_bytes(cells);
}

Version version_of(const Header& h)
{
  const auto is = [&](const char(&magic)[8])
  { return std::memcmp(h.magic, magic, sizeof h.magic) == 0; };
  if (is(kMagic)) return Version::Current;
  if (is(kMagicOfScans)) return Version::OfScans;
  if (is(kMagicOfOneSensor)) return Version::OneSensor;
  if (is(kMagicWithoutExtent)) return Version::WithoutExtent;
  fail("not a state of talus");
}

void check_place(const Header& h)
{
  const bool sound = is_within(static_cast<double>(h.min_cell_x), kFarthestCell) &&
                     is_within(static_cast<double>(h.min_cell_y), kFarthestCell) &&
                     is_within(h.reference_z_m, kHighest_m);
  if (!sound) fail("damaged, its place is none");
}

/** Of states that tell them. */
void read_time_and_datum(const Header& h, SavedMap& saved)
{
  if (!is_within(h.offset_m, kHighest_m) || !is_within(h.settled_m, kHighest_m))
    fail("damaged, its datum is none");
  saved.tracker.last_stamp_s = h.last_stamp_s;
  saved.map.datum = {h.offset_m, h.settled_m, (h.flags & kStartsAnew) != 0, h.drove_through};
}

/** The sensors of a state, and where they end in it. */
const std::uint8_t* read_sensors(
    const Header& h, Version version, const std::uint8_t* from, WindowTracker& tracker)
{
  if (!tells_sensors(version))
  {
    // The axis of the only sensor stands where stamps are now.
    tracker.sensors.push_back({0, {}});
    std::memcpy(tracker.sensors[0].z_axis.data(), &h.last_stamp_s, sizeof(double[3]));
  }
  const std::size_t behind = tells_sensors(version) ? h.sensors : 0;
  for (std::size_t i = 0; i < behind; i++, from += sizeof(SensorRecord))
  {
    SensorRecord r;
    std::memcpy(&r, from, sizeof r);
    const double(&z)[3] = r.z_axis;
    tracker.sensors.push_back({static_cast<std::uint32_t>(r.number), {z[0], z[1], z[2]}});
  }
  for (const auto& sensor : tracker.sensors)
    for (const double v : sensor.z_axis)
      if (!is_within(v, 2)) fail("damaged, the axes of its sensors are none");
  return from;
}

/** What the stages count on. */
void check_cells(const MapBytes& map, std::size_t cells)
{
  const std::uint8_t* const state = map.cells.data() + kCellFloats * sizeof(float) * cells;
  bool sound = true;
  enum Array : std::size_t
  {
    kGround,
    kElevation = 2  // each with its variance behind it
  };
  for (const std::size_t array : {kGround, kElevation})
    for (std::size_t i = 0; i < cells; i++)
    {
      float height_m, variance_m2;
      std::memcpy(&height_m, map.cells.data() + (array * cells + i) * sizeof(float), sizeof(float));
      std::memcpy(
          &variance_m2, map.cells.data() + ((array + 1) * cells + i) * sizeof(float),
          sizeof(float));
      const bool known =
          is_within(height_m, kHighest_m) && variance_m2 >= 0 && std::isfinite(variance_m2);
      const bool is_none = std::isnan(height_m) && std::isnan(variance_m2);
      sound &= known || (is_none && (array == kElevation || state[i] == kernels::kUnknown));
    }
  sound &=
      std::all_of(state, state + cells, [](std::uint8_t s) { return s <= kernels::kPresumed; });
  sound &= std::all_of(
      map.features.begin(), map.features.end(),
      [](float v) { return std::isnan(v) || is_within(v, 2); });
  if (!sound) fail("damaged, its cells are none of a map");
}

}  // namespace

std::vector<std::uint8_t> bytes_of(const SavedMap& saved, const Parameters& p)
{
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.cells = p.cells();
  header.started = saved.tracker.started;
  header.min_cell_x = saved.tracker.min_cell_x;
  header.min_cell_y = saved.tracker.min_cell_y;
  header.last_stamp_s = saved.tracker.last_stamp_s;
  header.offset_m = saved.map.datum.offset_m;
  header.settled_m = saved.map.datum.settled_m;
  header.drove_through = static_cast<std::uint8_t>(saved.map.datum.drove_through);
  header.flags = saved.map.datum.starts_anew ? kStartsAnew : 0;
  header.resolution_m = p.resolution_m;
  header.reference_z_m = saved.reference_z_m;
  header.sensors = static_cast<std::uint8_t>(saved.tracker.sensors.size());
  std::vector<std::uint8_t> bytes;
  const std::size_t of_features = saved.map.features.size() * sizeof(float);
  bytes.reserve(
      sizeof header + header.sensors * sizeof(SensorRecord) + saved.map.cells.size() + of_features);
  const auto append = [&](const void* from, std::size_t size)
  {
    const auto* first = static_cast<const std::uint8_t*>(from);
    bytes.insert(bytes.end(), first, first + size);
  };
  append(&header, sizeof header);
  for (const auto& sensor : saved.tracker.sensors)
  {
    const auto& z = sensor.z_axis;
    const SensorRecord record{sensor.number, {z[0], z[1], z[2]}};
    append(&record, sizeof record);
  }
  append(saved.map.cells.data(), saved.map.cells.size());
  append(saved.map.features.data(), of_features);
  return bytes;
}

bool is_size_of_state(std::uint64_t bytes, const Parameters& p)
{
  const std::size_t cells = cell_count(p);
  const auto is = [&](Version version, std::size_t sensors)
  { return bytes == sizeof(Header) + bytes_behind_header(cells, version, sensors); };
  for (std::size_t sensors = 1; sensors <= kMostSensors; sensors++)
    if (is(Version::Current, sensors)) return true;
  return is(Version::OneSensor, 1) || is(Version::WithoutExtent, 1);
}

SavedMap saved_map_from(const std::vector<std::uint8_t>& bytes, const Parameters& p)
{
  Header header;
  if (bytes.size() < sizeof header) fail("cut short");
  std::memcpy(&header, bytes.data(), sizeof header);
  const Version version = version_of(header);
  if (header.cells != p.cells() || header.resolution_m != p.resolution_m)
    fail("another window size or resolution");
  const std::size_t cells = cell_count(p), of_cells = cell_bytes(cells, version);
  if (header.started && tells_sensors(version) &&
      (header.sensors < 1 || header.sensors > kMostSensors))
    fail("damaged, it has no sensor or too many");
  if (bytes.size() !=
      sizeof header + (header.started ? bytes_behind_header(cells, version, header.sensors) : 0))
    fail("wrong length");

  SavedMap saved;
  if (!header.started) return saved;
  check_place(header);
  saved.tracker.started = true;
  saved.tracker.min_cell_x = header.min_cell_x;
  saved.tracker.min_cell_y = header.min_cell_y;
  saved.reference_z_m = header.reference_z_m;
  if (tells_sensors(version)) read_time_and_datum(header, saved);
  const std::uint8_t* const from =
      read_sensors(header, version, bytes.data() + sizeof header, saved.tracker);
  saved.map.cells.assign(from, from + of_cells);
  saved.map.cells.resize(cells * kBytesPerCell);  // of what is newer nothing is known
  if (version == Version::OfScans)
    std::for_each(
        saved.map.cells.end() - static_cast<std::ptrdiff_t>(cells), saved.map.cells.end(),
        [](std::uint8_t& footing) { footing &= 0xFE; });
  saved.map.features.resize(kFeatures * cells);
  std::memcpy(saved.map.features.data(), from + of_cells, feature_bytes(cells));
  check_cells(saved.map, cells);
  return saved;
}

}  // namespace talus
