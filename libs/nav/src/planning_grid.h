#pragma once
#include <talus/nav/costmap.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace talus::nav
{
/** What a cell of a costmap is for a robot that plans. */
enum class Ground : std::uint8_t
{
  Free,  //!< or unknown
  Stands,  //!< something stands there
  Edge  //!< the ground may end there
};

/** A costmap with free cells around, and how far each cell is from what blocks. */
class PlanningGrid
{
 public:
  static constexpr int kBorder_cells = 14;  //!< into which a robot may reach, but not drive
  static constexpr int kThirds = 3;  //!< of a cell; what distances are told in
  static constexpr int kFarthest_thirds = 255;
  static constexpr double kTooLong = 1.05;  //!< distances in them are at most, along (2, 1)

  PlanningGrid(const Costmap& costmap, double around_m);

  /** Makes the cells below the robot free, as it stands there. Before measure(). */
  void clear(const Pose2& at, const Footprint& robot);
  /** Computes the distances. */
  void measure();

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double cell_m() const { return cell_m_; }
  std::size_t size() const { return ground_.size(); }
  Ground ground(std::size_t cell) const { return ground_[cell]; }
  /** To the nearest cell in which something stands, and to the nearest edge; steps along rows and
   * columns count three, diagonal ones four. At most kFarthest_thirds. */
  int to_standing_thirds(std::size_t cell) const { return to_standing_[cell]; }
  int to_edge_thirds(std::size_t cell) const { return to_edge_[cell]; }

  int column_of(double x_m) const;
  int row_of(double y_m) const;
  std::size_t index(int column, int row) const
  {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  int column(std::size_t cell) const { return static_cast<int>(cell) % columns_; }
  int row(std::size_t cell) const { return static_cast<int>(cell) / columns_; }
  double x_m(int column) const { return min_x_m_ + (column + 0.5) * cell_m_; }
  double y_m(int row) const { return min_y_m_ + (row + 0.5) * cell_m_; }
  /** Whether the middle of a robot may be there. */
  bool contains(int column, int row) const
  {
    return column >= kBorder_cells && row >= kBorder_cells && column < columns_ - kBorder_cells &&
           row < rows_ - kBorder_cells;
  }

 private:
  std::vector<std::uint8_t> distances_to(Ground ground) const;

  int columns_, rows_;
  double min_x_m_, min_y_m_, cell_m_;
  std::vector<Ground> ground_;
  std::vector<std::uint8_t> to_standing_, to_edge_;
};

}  // namespace talus::nav
