#include "backend.h"
#include "kernels/cell.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace talus
{
namespace
{
constexpr char kMagic[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '8'};

/** The header comes before the sensors and the layers. */
struct Header
{
  char magic[8];
  std::int32_t cells;
  std::int32_t started;
  std::int64_t min_cell_x, min_cell_y;
  double resolution_m;
  float offset_m, reference_z_m;
  std::uint8_t sensors, flags, drove_through, reserved[5];
};

using Sensor = WindowTracker::Sensor;  // one after the other between the header and the layers
static_assert(std::is_trivially_copyable_v<Sensor> && sizeof(Sensor) == 32);

constexpr std::uint8_t kStartsAnew = 1;  //!< a bit of Header::flags, see kernels::Datum

constexpr std::size_t kFeatures = kLayerCount - static_cast<std::size_t>(Layer::Slope);
constexpr double kFarthestCell = 2e9, kHighest_m = 1e9;  //!< beyond what frames can reach

[[noreturn]] void fail(const std::string& what)
{
  throw std::invalid_argument("saved map: " + what);
}

std::size_t cell_count(const Parameters& p)
{
  const auto n = static_cast<std::size_t>(p.cells());
  return n * n;
}

std::size_t feature_bytes(std::size_t cells) { return kFeatures * cells * sizeof(float); }

bool is_within(double v, double limit) { return std::abs(v) <= limit; }  // false for NaN

/** The bytes after the header, for a map that has seen a frame. */
std::size_t bytes_behind_header(std::size_t cells, std::size_t sensors)
{
  return sensors * sizeof(Sensor) + cells * kernels::kBytesPerCell + feature_bytes(cells);
}

void check_position(const Header& h)
{
  const bool sound = is_within(static_cast<double>(h.min_cell_x), kFarthestCell) &&
                     is_within(static_cast<double>(h.min_cell_y), kFarthestCell) &&
                     is_within(h.reference_z_m, kHighest_m);
  if (!sound) fail("damaged, its place is none");
}

void read_datum(const Header& h, SavedMap& saved)
{
  if (!is_within(h.offset_m, kHighest_m)) fail("damaged, its datum is none");
  saved.map.datum = {h.offset_m, (h.flags & kStartsAnew) != 0, h.drove_through};
}

/** Reads the sensors of a state; returns where they end. */
const std::uint8_t* read_sensors(const Header& h, const std::uint8_t* from, WindowTracker& tracker)
{
  tracker.sensors.resize(h.sensors);
  std::memcpy(tracker.sensors.data(), from, h.sensors * sizeof(Sensor));
  for (const Sensor& sensor : tracker.sensors)
    for (const double v : sensor.z_axis)
      if (!is_within(v, 2)) fail("damaged, the axes of its sensors are none");
  return from + h.sensors * sizeof(Sensor);
}

kernels::CellStore cells_in(std::vector<std::uint8_t>& bytes, std::size_t cells)
{
  kernels::CellStore store{};
  std::uint8_t* at = bytes.data();
#define TALUS_IN_BYTES(type, name, unknown) \
  store.name = reinterpret_cast<type*>(at), at += cells * sizeof(type);
  TALUS_CELL_FIELDS(TALUS_IN_BYTES)
#undef TALUS_IN_BYTES
  return store;
}

void check_cells(MapBytes& map, std::size_t cells)
{
  const auto is_surface = [](float height_m, float variance_m2)
  { return is_within(height_m, kHighest_m) && variance_m2 >= 0 && std::isfinite(variance_m2); };
  const auto is_none = [](float height_m, float variance_m2)
  { return std::isnan(height_m) && std::isnan(variance_m2); };
  const kernels::CellStore store = cells_in(map.cells, cells);
  bool sound = true;
  for (int i = 0; i < static_cast<int>(cells); i++)
  {
    const kernels::Cell c = store.load(i);
    const bool no_ground = c.state == kernels::kUnknown && is_none(c.ground_m, c.ground_var_m2);
    const bool no_top = is_none(c.elevation_m, c.elevation_var_m2);
    sound &= c.state <= kernels::kPresumed &&
             (no_ground || is_surface(c.ground_m, c.ground_var_m2)) &&
             (no_top || is_surface(c.elevation_m, c.elevation_var_m2));
  }
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
  header.offset_m = saved.map.datum.offset_m;
  header.drove_through = static_cast<std::uint8_t>(saved.map.datum.drove_through);
  header.flags = saved.map.datum.starts_anew ? kStartsAnew : 0;
  header.resolution_m = p.resolution_m;
  header.reference_z_m = saved.reference_z_m;
  header.sensors = static_cast<std::uint8_t>(saved.tracker.sensors.size());
  std::vector<std::uint8_t> bytes;
  const std::size_t of_sensors = header.sensors * sizeof(Sensor);
  const std::size_t of_features = saved.map.features.size() * sizeof(float);
  bytes.reserve(sizeof header + of_sensors + saved.map.cells.size() + of_features);
  const auto append = [&](const void* from, std::size_t size)
  {
    const auto* first = static_cast<const std::uint8_t*>(from);
    bytes.insert(bytes.end(), first, first + size);
  };
  append(&header, sizeof header);
  append(saved.tracker.sensors.data(), of_sensors);
  append(saved.map.cells.data(), saved.map.cells.size());
  append(saved.map.features.data(), of_features);
  return bytes;
}

bool ElevationMapper::is_size_of_state(std::uint64_t bytes, const Parameters& p)
{
  p.validate();
  for (std::size_t sensors = 1; sensors <= kMaxSensors; sensors++)
    if (bytes == sizeof(Header) + bytes_behind_header(cell_count(p), sensors)) return true;
  return false;
}

SavedMap saved_map_from(const std::vector<std::uint8_t>& bytes, const Parameters& p)
{
  Header header;
  if (bytes.size() < sizeof header) fail("cut short");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0) fail("not a state of talus");
  if (header.cells != p.cells() || header.resolution_m != p.resolution_m)
    fail("another window size or resolution");
  const std::size_t cells = cell_count(p), of_cells = cells * kernels::kBytesPerCell;
  if (header.started && (header.sensors < 1 || header.sensors > kMaxSensors))
    fail("damaged, it has no sensor or too many");
  if (bytes.size() !=
      sizeof header + (header.started ? bytes_behind_header(cells, header.sensors) : 0))
    fail("wrong length");

  SavedMap saved;
  if (!header.started) return saved;
  check_position(header);
  saved.tracker.started = true;
  saved.tracker.min_cell_x = header.min_cell_x;
  saved.tracker.min_cell_y = header.min_cell_y;
  saved.reference_z_m = header.reference_z_m;
  read_datum(header, saved);
  const std::uint8_t* const from =
      read_sensors(header, bytes.data() + sizeof header, saved.tracker);
  saved.map.cells.assign(from, from + of_cells);
  saved.map.features.resize(kFeatures * cells);
  std::memcpy(saved.map.features.data(), from + of_cells, feature_bytes(cells));
  check_cells(saved.map, cells);
  return saved;
}

static_assert(kOtherFloor_m == kernels::kOtherFloor_m);

constexpr int kFlagsByte = 0;  // they come first, see TALUS_CELL_EVIDENCE

bool is_reached(const CellRecord& record)
{
  return (record.evidence[kFlagsByte] & kernels::kWasReached) != 0;
}
void set_reached(CellRecord& record) { record.evidence[kFlagsByte] |= kernels::kWasReached; }

void clear_transient_evidence(CellRecord& record)
{
  std::fill(record.evidence + CellRecord::kLastingBytes, std::end(record.evidence), 0);
}

}  // namespace talus
