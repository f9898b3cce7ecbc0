#include <octomap/OcTree.h>
#include <talus/formats/convert.h>
#include <talus/formats/write.h>
#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include "needed_layer.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace talus::formats
{
namespace
{
/** Sets the voxels of a column from one height to another, both included. */
class Column
{
 public:
  Column(octomap::OcTree& tree, double x_m, double y_m) : tree_(tree), x_m_(x_m), y_m_(y_m) {}
  void set(double from_m, double to_m, float log_odds)
  {
    octomap::OcTreeKey low, high;
    if (!key(from_m, low) || !key(to_m, high))
      throw std::runtime_error(
          "the map reaches farther than a tree of OctoMap does: 32768 voxels from its origin");
    for (; low[2] <= high[2]; ++low[2]) tree_.setNodeValue(low, log_odds, true);
  }

 private:
  bool key(double z_m, octomap::OcTreeKey& k) const
  {
    return tree_.coordToKeyChecked(
        octomap::point3d(
            static_cast<float>(x_m_), static_cast<float>(y_m_), static_cast<float>(z_m)),
        k);
  }
  octomap::OcTree& tree_;
  double x_m_, y_m_;
};

/** Whether a tree of such voxels reaches all that is known. */
bool reaches_all(const MapStrips& map, double clearance_m, const FileOrigin& o)
{
  constexpr double kFarthest_voxels = 32766;  // of 32768: where voxels and cells are cut apart
  double farthest_m = 0;
  map.for_each(
      [&](const Strip& strip)
      {
        const Heights h(strip.map);
        for_each_cell(
            strip,
            [&](std::size_t i, int ix, int iy)
            {
              if (std::isnan(h.ground[i])) return;
              const double low_m = h.ground[i] - o.z_m, high_m = low_m + clearance_m;
              for (const double m :
                   {middle_x_m(strip.map, ix) - o.x_m, middle_y_m(strip.map, iy) - o.y_m, low_m,
                    high_m, h.stands(i) ? h.top[i] - o.z_m : high_m})
                farthest_m = std::max(farthest_m, std::abs(m));
            });
      });
  return farthest_m < kFarthest_voxels * map.frame().resolution_m;
}

void fill_strip(const Strip& strip, double clearance_m, const FileOrigin& o, octomap::OcTree& out)
{
  const io::LayerStack& map = strip.map;
  const Heights h(map);
  const auto& state = needed_layer(map, Layer::State);
  const auto& score = needed_layer(map, Layer::Traversability);
  const auto is_guess = [&](std::size_t i)  // that no ray has proved, as outside of a room
  {
    return state[i] == static_cast<float>(CellState::FilledOneSided) && std::isnan(score[i]) &&
           !h.stands(i);
  };
  const float occupied = out.getClampingThresMaxLog(), free = out.getClampingThresMinLog();
  for_each_cell(
      strip,
      [&](std::size_t i, int ix, int iy)
      {
        if (std::isnan(h.ground[i]) || is_guess(i)) return;
        Column column(out, middle_x_m(map, ix) - o.x_m, middle_y_m(map, iy) - o.y_m);
        const double ground_m = h.ground[i] - o.z_m;
        const bool measured = state[i] == static_cast<float>(CellState::Measured);
        if (measured && !h.stands(i))
          column.set(ground_m + map.resolution_m, ground_m + clearance_m, free);
        column.set(ground_m, h.stands(i) ? h.top[i] - o.z_m : ground_m, occupied);
      });
}

void fill(const MapStrips& map, double clearance_m, const FileOrigin& o, octomap::OcTree& out)
{
  map.for_each([&](const Strip& strip) { fill_strip(strip, clearance_m, o, out); });
  out.updateInnerOccupancy();
  out.prune();
}
}  // namespace

void to_octomap(const io::LayerStack& map, double clearance_m, octomap::OcTree& out)
{
  fill(map, clearance_m, {}, out);
}

std::string write_octomap(
    const std::string& path, const MapStrips& map, double clearance_m, const FileOrigin& origin)
{
  const MapStrips shown =
      joined_until([&](const MapStrips& m) { return reaches_all(m, clearance_m, origin); }, map);
  octomap::OcTree tree(shown.frame().resolution_m);
  fill(shown, clearance_m, origin, tree);
  std::ostringstream bytes;  // with a head of our own: writeBinaryConst() says "done."
  bytes << "# Octomap OcTree binary file\n";
  if (moves(origin)) bytes << "# origin_m: " << text_of(origin) << "\n";
  bytes << "id OcTree\nsize " << tree.size() << "\nres " << number_text(tree.getResolution())
        << "\ndata\n";
  if (tree.size() > 0) tree.writeBinaryData(bytes);
  io::write_file(path, bytes.str());
  const double made_m = shown.frame().resolution_m, resolution_m = map.frame().resolution_m;
  if (made_m == resolution_m) return "";
  return path + ": its voxels are " + number_text(made_m) + " m wide, not " +
         number_text(resolution_m) +
         " m: a tree of OctoMap reaches 32768 voxels from its origin, and no farther";
}

}  // namespace talus::formats
