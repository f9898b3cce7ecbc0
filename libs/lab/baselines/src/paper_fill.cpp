#include <talus/baselines/cell_line.h>
#include <talus/baselines/fills.h>
#include <talus/baselines/paper_map.h>

#include <algorithm>
#include <limits>

namespace talus::baselines
{
namespace
{
constexpr double kLambda = 1;  //!< weight of the prior, see eq. 8; the paper's value

/** What one direction of the line search found. */
struct Side
{
  int samples = 0;
  int gap_cells = 0;  //!< before the first sample: n1, n2 of eq. 9
  double height_m = 0;  //!< eq. 8
};

/** Eq. 8 with the lowest sample as the prior. `direction`: 1 away from the sensor, -1 towards it
 * (and on behind it). */
Side search(const PaperCells& cells, const CellLine& line, int direction, const Parameters& p)
{
  Side side;
  double weights = 0, weighted_m = 0, lowest_m = std::numeric_limits<double>::infinity();
  const auto farthest = static_cast<int>(p.fill_search_m / line.step_m());
  for (int k = 1; k <= farthest; ++k)
  {
    const int at = line(line.steps() + direction * k);
    if (at < 0) break;
    const PaperCell& c = cells[static_cast<std::size_t>(at)];
    if (c.state != CellState::Measured) continue;
    if (side.samples++ == 0) side.gap_cells = k - 1;
    const double weight = sparse_kernel(k * line.step_m(), p.fill_kernel_m);
    weights += weight;
    weighted_m += weight * c.ground_m;
    lowest_m = std::min(lowest_m, static_cast<double>(c.ground_m));
  }
  side.height_m = (kLambda * lowest_m + weighted_m) / (kLambda + weights);
  return side;
}

/** Eq. 9. */
double combine(const Side& a, const Side& b)
{
  const Side& low = a.height_m <= b.height_m ? a : b;
  const Side& high = a.height_m <= b.height_m ? b : a;
  const int n_low = low.gap_cells, n_high = high.gap_cells;
  if (n_low + n_high == 0) return (low.height_m + high.height_m) / 2;  // 0 / 0: a gap of one cell
  return ((n_low + n_high) * low.height_m + n_high * high.height_m) / (n_low + 2 * n_high);
}

}  // namespace

PaperFill infer_as_printed(
    const PaperCells& cells, const Pose& T_map_sensor, int cell, const Parameters& p)
{
  const int n = cells.window().cells;
  const CellLine line(cells.window(), T_map_sensor, cell % n, cell / n);
  PaperFill fill{0, CellState::Unknown};
  if (line.steps() == 0) return fill;
  const Side inner = search(cells, line, -1, p), outer = search(cells, line, 1, p);
  if (inner.samples > 0 && outer.samples > 0)
    fill = {static_cast<float>(combine(inner, outer)), CellState::FilledTwoSided};
  else if (inner.samples > 0 || outer.samples > 0)
    fill = {
        static_cast<float>(inner.samples > 0 ? inner.height_m : outer.height_m),
        CellState::FilledOneSided};
  return fill;
}

}  // namespace talus::baselines
