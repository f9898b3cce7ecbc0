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
constexpr char kMagic[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '4'};
/** Of states that were saved before: without the last array of the cells. */
constexpr char kMagicWithoutExtent[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '2'};

/** What stands before the layers. */
struct Header
{
  char magic[8];
  std::int32_t cells;
  std::int32_t started;
  std::int64_t min_cell_x, min_cell_y;
  double last_z_axis[3];
  double resolution_m;
  float reference_z_m;
  std::uint32_t reserved;
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

/** Behind the header, of a map that has seen a frame. Older states are without one array. */
std::size_t cell_bytes(std::size_t cells, bool older) { return cells * (kBytesPerCell - older); }
std::size_t feature_bytes(std::size_t cells) { return kFeatures * cells * sizeof(float); }

bool is_within(double v, double limit) { return std::abs(v) <= limit; }  // not NaN

void check_header(const Header& h)
{
  const bool sound =
      std::all_of(h.last_z_axis, h.last_z_axis + 3, [](double v) { return is_within(v, 2); }) &&
      is_within(static_cast<double>(h.min_cell_x), kFarthestCell) &&
      is_within(static_cast<double>(h.min_cell_y), kFarthestCell) &&
      is_within(h.reference_z_m, kHighest_m);
  if (!sound) fail("damaged, its place is none");
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
  sound &= std::all_of(
      state, state + cells, [](std::uint8_t s) { return s <= kernels::kFilledOneSided; });
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
  std::copy_n(saved.tracker.last_z_axis.begin(), 3, header.last_z_axis);
  header.resolution_m = p.resolution_m;
  header.reference_z_m = saved.reference_z_m;
  const auto* head = reinterpret_cast<const std::uint8_t*>(&header);
  const auto* features = reinterpret_cast<const std::uint8_t*>(saved.map.features.data());
  const std::size_t of_features = saved.map.features.size() * sizeof(float);
  std::vector<std::uint8_t> bytes(sizeof header + saved.map.cells.size() + of_features);
  auto to = std::copy_n(head, sizeof header, bytes.begin());
  to = std::copy(saved.map.cells.begin(), saved.map.cells.end(), to);
  std::copy_n(features, of_features, to);
  return bytes;
}

bool is_size_of_state(std::uint64_t bytes, const Parameters& p)
{
  const std::size_t cells = cell_count(p);
  for (const bool older : {false, true})
    if (bytes == sizeof(Header) + cell_bytes(cells, older) + feature_bytes(cells)) return true;
  return false;
}

SavedMap saved_map_from(const std::vector<std::uint8_t>& bytes, const Parameters& p)
{
  Header header;
  if (bytes.size() < sizeof header) fail("cut short");
  std::memcpy(&header, bytes.data(), sizeof header);
  const bool older = std::memcmp(header.magic, kMagicWithoutExtent, sizeof kMagic) == 0;
  if (!older && std::memcmp(header.magic, kMagic, sizeof kMagic) != 0) fail("not a state of talus");
  if (header.cells != p.cells() || header.resolution_m != p.resolution_m)
    fail("another window size or resolution");
  const std::size_t cells = cell_count(p), of_cells = cell_bytes(cells, older);
  if (bytes.size() != sizeof header + (header.started ? of_cells + feature_bytes(cells) : 0))
    fail("wrong length");

  SavedMap saved;
  if (!header.started) return saved;
  check_header(header);
  const double(&z)[3] = header.last_z_axis;
  saved.tracker = {true, header.min_cell_x, header.min_cell_y, {z[0], z[1], z[2]}};
  saved.reference_z_m = header.reference_z_m;
  const std::uint8_t* const from = bytes.data() + sizeof header;
  saved.map.cells.assign(from, from + of_cells);
  saved.map.cells.resize(cells * kBytesPerCell);  // no extents are known
  saved.map.features.resize(kFeatures * cells);
  std::memcpy(saved.map.features.data(), from + of_cells, feature_bytes(cells));
  check_cells(saved.map, cells);
  return saved;
}

}  // namespace talus
