#pragma once
#include <array>
#include <cstdint>

namespace talus
{
/** The layers of the map, in the order in which files list them. float32, heights in the map frame.
 *
 * NaN: nothing is known. A height or variance that the cell has not; a score or traversability that
 * was not judged, since fewer than three cells of the neighbourhood have ground. That is not 0,
 * impassable: whoever drives decides what it means (see ObstacleOptions::unseen of talus::mrpt).
 * NaN > 0 and NaN <= 0 are both false. State is never NaN. */
enum class Layer : int
{
  Elevation = 0,  //!< [m] top of what stands on the ground
  GroundElevation,  //!< [m] the ground, measured or filled
  Variance,  //!< [m^2] of the ground elevation
  State,  //!< a CellState, as a number
  Reached,  //!< 1: the robot gets there over passable cells; 0: it does not, see stage 4
  Slope,  //!< [0,1] eq. 10, 1: flat
  Step,  //!< [0,1] eq. 11, 1: no step
  Roughness,  //!< [0,1] eq. 12, 1: smooth
  Sparsity,  //!< [0,1] eq. 14, only at fills that may drop: below 0.5; 0: likely a ditch, or
             //!< remembered
  Traversability,  //!< [0,1] eq. 13, 1: free, 0: impassable
};
constexpr int kLayerCount = 10;

/** Band names of files and of the Python-free world: "elevation", "ground_elevation", ... */
constexpr std::array<const char*, kLayerCount> kLayerNames{
    "elevation", "ground_elevation", "variance", "state",         "reached", "slope",
    "step",      "roughness",        "sparsity", "traversability"};

constexpr const char* layer_name(Layer l) { return kLayerNames[static_cast<int>(l)]; }

/** Where the ground height of a cell comes from. */
enum class CellState : std::uint8_t
{
  Unknown = 0,
  Measured = 1,
  FilledTwoSided = 2,  //!< reliable
  FilledOneSided = 3,  //!< a guess, refilled as soon as better data arrives
  Presumed = 4  //!< not measured: the ground on which the robot stood, or started
};

constexpr int kCellStates = 5;

}  // namespace talus
