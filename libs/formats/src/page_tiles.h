#pragma once
#include <talus/io/layer_stack.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace talus::formats
{
/** How the numbers of a page's pictures become values. */
struct PageCode
{
  double lowest_m = 0, step_m = 0.005;  //!< height = lowest_m + (code - 1) step_m
  static constexpr double kTallStep_m = 0.05;  //!< of what stands
  static constexpr double kChangeStep_m = 0.02;
  static constexpr int kAgeSteps = 16;  //!< age = 2^(code / 16) - 1 s
  double oldest_s = 0;  //!< the largest age
  std::size_t known_cells = 0;

  /** Of a layer of a channel: value = lowest + (code - 1) step, 0: none. */
  struct Channel
  {
    std::string name;
    double lowest = 0, highest = 0, step = 1;
    bool is_class = false;  //!< all its values are whole numbers from 0 to 15
  };
  std::vector<Channel> channels;
};

/** The cells of a square of a page, as pictures in which a pixel is a cell. */
struct PageTile
{
  int column, row;  //!< rows count from the north
  /** A .png: red and green the code of the ground, 0 unknown, blue the traversability in 254ths,
   * 255 not judged. */
  std::vector<unsigned char> ground;
  /** A .png: red what stands, in steps; green the code of the age, 255 none; blue the state in bits
   * 0 to 2, whether it may drop in bit 3, the light of the hill-shade in bits 4 to 7. */
  std::vector<unsigned char> more;
  /** A .png: red the kind of the change, green its size in steps; empty where there is none. */
  std::vector<unsigned char> changes;
  /** Each a .png: red, green and blue the codes of three layers of channels, in their order. */
  std::vector<std::vector<unsigned char>> channels;
};

constexpr int kPageTile_cells = 512;  //!< side of a tile

/** The tiles in which a cell is known, from the north; nothing once they have more than
 * `max_bytes`. `changes` may be nullptr, else it has the cells of `map`. */
std::optional<std::vector<PageTile>> page_tiles(
    const io::LayerStack& map, const io::LayerStack* changes, std::size_t max_bytes,
    PageCode& code);

}  // namespace talus::formats
