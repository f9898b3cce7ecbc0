#pragma once
#include <opencv2/core.hpp>
#include <talus/baselines/method.h>
#include <talus/io/layer_stack.h>

#include <string>
#include <vector>

#include "oblique.h"

namespace talus::pictures
{
/** A tile of a sheet. */
struct Tile
{
  std::string title;  //!< bold
  std::string words;  //!< below it, faint
  cv::Mat image;  //!< 8-bit BGR, tile_px wide and high
};

/** A square around the middle of the map: `side_m` of it, north up, as map.png shows a layer.
 * Throws std::invalid_argument for a layer that the stack does not have. */
cv::Mat layer_image(
    const io::LayerStack& stack, const std::string& layer, double side_m, int tile_px);

/** Which colours a sheet explains. */
enum class SheetLegend
{
  All,
  Scores
};

/** All tiles, `columns` in a row, with what the colours mean below, and the words; a wider gap
 * after every `together` tiles. */
cv::Mat draw_sheet(
    const std::vector<Tile>& tiles, int columns, int together, const std::string& words,
    SheetLegend explained = SheetLegend::All);

/** The points of some scans of a drive, all coloured by what the map says of them after the last
 * one, above what the colours mean. */
cv::Mat draw_labelled_scans(
    const std::vector<baselines::ScanFrame>& frames, std::size_t every, const Camera& camera);

/** Pictures of a drive, seen from one place: the maps that talus-map --every wrote, in their order,
 * each over those of before, with the robot in the middle of the newest. Writes
 * FOLDER/drive_000.png and so on. Throws std::runtime_error that names the file. */
void write_drive(
    const std::vector<std::string>& maps, const Camera& camera, const std::string& folder);

}  // namespace talus::pictures
