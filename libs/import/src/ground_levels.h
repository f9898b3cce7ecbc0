#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "point_fields.h"

namespace talus::import
{
/** The ground of a cloud: of the surfaces in each column those that connect with each other. Roofs
 * and ceilings do not connect with what is below them. */
class GroundLevels
{
 public:
  explicit GroundLevels(const ScanFile& cloud);

  /** Begins below a position, where there is a surface within a few metres. False: there is none.
   */
  bool reach_from(double x_m, double y_m, double z_m);
  /** Begins on the largest surfaces too that are not reached, and are not above or beside ground
   * that lies lower. */
  void reach_rest();

  /** Height of the ground below a point; nothing where none is near. */
  std::optional<double> below(double x_m, double y_m, double z_m);
  /** Whether some column has several. */
  bool has_storeys() const;

 private:
  struct Level
  {
    float bottom_m;
    bool is_reached = false;
  };
  struct Node
  {
    int x, y;
    std::size_t level;
  };
  using Columns = std::unordered_map<std::uint64_t, std::vector<Level>>;
  static std::uint64_t key(int x, int y);
  std::vector<Level>* column(int x, int y);
  std::vector<Node> spread(Node from);
  bool is_above_ground(const Node& node);

  Columns columns_;
  std::unordered_map<std::uint64_t, std::vector<float>> grounds_;  //!< by column, once asked for
};

}  // namespace talus::import
