#pragma once
#include <talus/cell_record.h>
#include "kernels/cell.h"

namespace talus
{
/** Cells of a rectangle of the window, as records on the host. */
struct HandOver
{
  const kernels::Config* config;
  const kernels::FrameContext* frame;
  kernels::CellStore store;
  float* traversability;  //!< window order
  CellRecord* records;  //!< row by row
  int first_x, first_y, width;  //!< the rectangle, in cells of the window

  TALUS_HD CellRecord& record(int x, int y) const { return records[y * width + x]; }
  TALUS_HD int window_i(int x, int y) const { return (first_y + y) * config->cells + first_x + x; }
  TALUS_HD int storage_i(int x, int y) const
  {
    return kernels::storage_index(*frame, config->cells, first_x + x, first_y + y);
  }
  /** NaN stays the one that it is. */
  static TALUS_HD float raised(float height_m, float by_m)
  {
    return kernels::select(kernels::is_known(height_m), height_m + by_m, kernels::kNan);
  }
};

struct ReadCell : HandOver
{
  TALUS_HD void operator()(int x, int y) const
  {
    const kernels::Cell c = store.load(storage_i(x, y));
    CellRecord r;
    r.ground_m = raised(c.ground_m, frame->offset_m);
    r.ground_variance_m2 = c.ground_var_m2;
    r.elevation_m = raised(c.elevation_m, frame->offset_m);
    r.elevation_variance_m2 = c.elevation_var_m2;
    r.traversability = traversability[window_i(x, y)];
    r.state = static_cast<std::uint8_t>(c.state);
    r.persistence = static_cast<std::int8_t>(c.persistence);
    r.ray_evidence = static_cast<std::uint8_t>(c.ray_evidence);
    r.extent = static_cast<std::uint8_t>(c.extent);
    r.footing = static_cast<std::uint8_t>(c.footing);
    record(x, y) = r;
  }
};

/** Of those that are not unknown. */
struct WriteCell : HandOver
{
  TALUS_HD void operator()(int x, int y) const
  {
    const CellRecord& r = record(x, y);
    if (r.state == kernels::kUnknown) return;
    store.store(
        storage_i(x, y), {raised(r.ground_m, -frame->offset_m), r.ground_variance_m2,
                          raised(r.elevation_m, -frame->offset_m), r.elevation_variance_m2, r.state,
                          r.persistence, r.ray_evidence, r.extent, r.footing});
    traversability[window_i(x, y)] = r.traversability;
  }
};

}  // namespace talus
