#pragma once
#include <talus/map_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "surface_view.h"

namespace talus::nav
{
constexpr float kObject_m = 0.1F;  // lower than this nothing stands in the way

/** From a cell to one beside it. */
struct Direction
{
  int dx, dy;
};

/** Whether a slope explains how far the ground falls where it was not seen: by the measured ground
 * on both sides, along four lines through the cell, wherever the robot is. Along an edge, an edge
 * looks gentle. */
class Falls
{
 public:
  /** `in_doubt`: whether a cell may be asked for. */
  Falls(const MapView& map, std::function<bool(int, int)> in_doubt);

  /** Of a cell in doubt. */
  bool is_slope(int ix, int iy) const;

 private:
  enum class Verdict : std::int8_t
  {
    NotAsked,
    Slope,
    Drop
  };
  /** Where a line meets measured ground. */
  struct End
  {
    double distance_m, ground_m;
    std::optional<double> face_top_m;  //!< of what stands there, or rises steeply behind
  };
  using Ends = std::array<std::optional<End>, 8>;
  struct Fall
  {
    bool as_slope = false;  //!< as far as a slope does
    bool farther = false;  //!< than one explains
  };

  bool is_measured(std::size_t cell) const;
  std::optional<double> face_top_m(int ix, int iy, const Direction& to) const;
  std::optional<End> end_of(int ix, int iy, const Direction& to) const;
  bool is_open(const Ends& ends) const;
  Fall fall(const End& high, const End& low) const;
  Fall fall_at(int ix, int iy) const;
  void judge_patch(int ix, int iy) const;

  SurfaceView view_;
  std::function<bool(int, int)> in_doubt_;
  double max_slope_, step_m_;
  mutable std::vector<Verdict> verdicts_;  //!< of the cells that were asked for
};

}  // namespace talus::nav
