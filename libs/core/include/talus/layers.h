#pragma once
#include <cstdint>
#include <string_view>

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
constexpr int kLayerCount = static_cast<int>(Layer::Traversability) + 1;

/** What the values of a layer are: how they are packed, joined and painted. */
enum class LayerKind
{
  Height,  //!< [m] in the map frame
  Variance,  //!< its square root is shown
  State,  //!< a CellState
  Score,  //!< [0,1]
  Amount  //!< any other number
};

/** What files and pictures say of a layer. */
struct LayerInfo
{
  const char* name;  //!< of bands, options and records
  const char* unit;  //!< "" for none
  LayerKind kind;  //!< of its values
  const char* title = nullptr;  //!< over a picture, with the unit; null: the name
  const char* low_word = "";  //!< meaning of 0, of scores
  const char* high_word = "";  //!< meaning of 1
  const char* classes = nullptr;  //!< what its numbers mean, where they are few
};

/** Those of the map in the order of Layer, then other bands of files. */
constexpr LayerInfo kLayerTable[] = {
    {"elevation", "m", LayerKind::Height, "Elevation [m]"},
    {"ground_elevation", "m", LayerKind::Height, "Ground elevation [m]"},
    {"variance", "m2", LayerKind::Variance, "Ground height, standard deviation [m]"},
    {"state", "", LayerKind::State, "Where the ground height comes from", "", "",
     "0 unknown, 1 measured, 2 filled from two sides, 3 filled from one side, 4 presumed"},
    {"reached", "", LayerKind::Score, "Reached from where the robot stands", "no", "yes",
     "0 the robot does not get there over passable cells, 1 it does"},
    {"slope", "", LayerKind::Score, "Slope score", "too steep", "level"},
    {"step", "", LayerKind::Score, "Step score", "too high", "no step"},
    {"roughness", "", LayerKind::Score, "Roughness score", "too rough", "smooth"},
    {"sparsity", "", LayerKind::Score, "Sparsity score (where ground may drop)", "ditch?",
     "harmless"},
    {"traversability", "", LayerKind::Score, "Traversability", "blocked", "free"},
    // Beside them, of a window:
    {"risk", "", LayerKind::Amount, "Risk (probability that a cell is impassable)"},
    // Of a site:
    {"age", "s", LayerKind::Amount},
    {"elevation_variance", "m2", LayerKind::Amount},
    {"evidence", "", LayerKind::Amount},
    {"shape", "", LayerKind::Amount},
    // Of what changed:
    {"change_m", "m", LayerKind::Amount},
    {"kind", "", LayerKind::Amount, nullptr, "", "",
     "0 none, 1 built, 2 dug, 3 object gone, 4 object new"},
    // Of what moved:
    {"times", "", LayerKind::Amount},
    {"scans", "", LayerKind::Amount},
    {"speed_mps", "m/s", LayerKind::Amount}};

constexpr const LayerInfo& layer_info(Layer l) { return kLayerTable[static_cast<int>(l)]; }
constexpr const char* layer_name(Layer l) { return layer_info(l).name; }

/** By its name; null for those of channels, and for what is not known. */
inline const LayerInfo* find_layer(std::string_view name)
{
  for (const LayerInfo& layer : kLayerTable)
    if (name == layer.name) return &layer;
  return nullptr;
}

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
