#pragma once
#include <talus/formats/page.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace talus::formats
{
/** How the numbers of a page's pictures become values; heights, see PageTile. */
struct PageCode
{
  static constexpr double kStep_m = 0.005;  //!< of heights, unless a tile has more than 300 m
  static constexpr double kTallStep_m = 0.05;  //!< of what stands
  static constexpr double kChangeStep_m = 0.02;
  static constexpr int kAgeSteps = 16;  //!< age = 2^(code / 16) - 1 s

  /** Of a layer of a channel: value = lowest + (code - 1) step, 0: none. */
  struct Channel
  {
    std::string name;
    double lowest = 0, highest = 0, step = 1;
    bool is_class = false;  //!< all its values are whole numbers from 0 to 15

    /** Looks at values of it. */
    void add(const std::vector<float>& layer);
    /** Once it has seen all. */
    void finish();

   private:
    bool is_whole_ = true, is_empty_ = true;
  };
  std::vector<Channel> channels;
};

/** The cells of a square of a page, as pictures in which a pixel is a cell. */
struct PageTile
{
  int column = 0, row = 0;  //!< rows count from the north
  double lowest_m = 0, step_m = PageCode::kStep_m;  //!< height = lowest_m + (code - 1) step_m
  std::size_t known_cells = 0;
  double oldest_s = 0;  //!< the largest age
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

  /** Of all pictures. */
  std::size_t bytes() const;
};

constexpr int kPageTile_cells = 512;  //!< side of a tile

/** Of a square of a map and what lies around it, which changes its light. */
struct PagePart
{
  io::LayerStack cells;
  io::LayerStack changes;  //!< of the same cells; without layers: none
  int west = 0, north = 0;  //!< cells around it on these sides
  int cells_x = 0, cells_y = 0;  //!< of the square
};

/** Nothing where no cell of it is known or has changed. */
std::optional<PageTile> page_tile(const PagePart& part, const PageCode& code);

/** As a list of JavaScript: column, row, lowest_m, step_m, and the pictures. */
std::string text_of(const PageTile& tile);

}  // namespace talus::formats
