#pragma once
#include <talus/elevation_mapper.h>
#include "scans.h"

#include <string>
#include <vector>

namespace talus::bench
{
/** Cells that a frame hands over, as for a map of a whole drive: those that leave the window, and
 * those that come into it, which may be given back. */
enum class HandedOver
{
  Nothing,
  Read,
  ReadAndWritten
};

/** What one line of the table measures. */
struct Setting
{
  std::string name;
  std::size_t points;
  int cells;  //!< along each side
  std::vector<Layer> layers;  //!< that go back to the host
  /** The next frame is started before each is finished; what is measured is from finish to finish.
   * The CPU backend leaves these settings out. */
  bool overlapped = false;
  double apart_m = 0.07;  //!< between frames
  HandedOver cells_handed_over = HandedOver::Nothing;

  double points_and_cells() const
  {
    return static_cast<double>(points) + static_cast<double>(cells) * cells;
  }
};

/** S1, the paper's; S2; variants of both, of which `roll` moves the window by two cells in each
 * frame; sweeps over points and cells. */
std::vector<Setting> settings();

Parameters parameters(const Setting& s);

/** Scan i of the setting's drive, made once: forth and back, so that the window rolls in every
 * frame and the drive never ends. */
const Scan& scan_at(const Setting& s, int i);

}  // namespace talus::bench
