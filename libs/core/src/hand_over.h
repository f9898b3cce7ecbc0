#pragma once
#include <talus/cell_record.h>
#include <talus/channels.h>
#include <talus/point_labels.h>
#include "kernels/8_label.h"
#include "kernels/9_channels.h"
#include "kernels/map.h"

#include <algorithm>

namespace talus
{
static_assert(CellRecord::kEvidenceBytes == kernels::kEvidenceFields);
static_assert(CellRecord::kLastingBytes == kernels::kEvidenceFields - kernels::kTransientFields);

/** A rectangle of cells of the window. */
struct WindowRect
{
  int first_x, first_y, width, height;

  TALUS_HD int size() const { return width * height; }
};

/** All cells of a window of n x n that are at most so many cells from a rectangle. */
inline WindowRect within(int cells, const WindowRect& rect, int n)
{
  const int x = std::max(rect.first_x - cells, 0), y = std::max(rect.first_y - cells, 0);
  return {
      x, y, std::min(rect.first_x + rect.width + cells, n) - x,
      std::min(rect.first_y + rect.height + cells, n) - y};
}

struct WindowRects
{
  static constexpr int kMax = 8;
  WindowRect rects[kMax];

  /** Finds cell i, row by row, one rectangle after the other. */
  TALUS_HD void find(int i, int& x, int& y) const
  {
    const WindowRect* in = rects;
    for (; i >= in->size(); in++) i -= in->size();
    x = in->first_x + i % in->width;
    y = in->first_y + i / in->width;
  }
};

/** Cells of the window that are handed over as records on the host. */
struct HandOver
{
  kernels::Map m;
  WindowRects cells;

  struct Index
  {
    int window_i, storage_i;
  };
  TALUS_HD Index index(int i) const
  {
    int x, y;
    cells.find(i, x, y);
    return {m.window_at(x, y), m.at(x, y)};
  }
};

/** The record of a cell, and the cell of a record, whose heights are `offset_m` higher. */
TALUS_HD CellRecord record_of(const kernels::Cell& c, float traversability, float offset_m)
{
  CellRecord r;
  r.ground_m = kernels::raised(c.ground_m, offset_m);
  r.ground_variance_m2 = c.ground_var_m2;
  r.elevation_m = kernels::raised(c.elevation_m, offset_m);
  r.elevation_variance_m2 = c.elevation_var_m2;
  r.traversability = traversability;
  r.state = static_cast<std::uint8_t>(c.state);
  std::uint8_t* to = r.evidence;
#define TALUS_READ(type, name, unknown) *to++ = static_cast<std::uint8_t>(c.name);
  TALUS_CELL_EVIDENCE(TALUS_READ)
#undef TALUS_READ
  return r;
}
TALUS_HD kernels::Cell cell_of(const CellRecord& r, float offset_m)
{
  kernels::Cell c;
  c.ground_m = kernels::raised(r.ground_m, -offset_m);
  c.ground_var_m2 = r.ground_variance_m2;
  c.elevation_m = kernels::raised(r.elevation_m, -offset_m);
  c.elevation_var_m2 = r.elevation_variance_m2;
  c.state = r.state;
  const std::uint8_t* from = r.evidence;
#define TALUS_WRITE(type, name, unknown) c.name = *from++;
  TALUS_CELL_EVIDENCE(TALUS_WRITE)
#undef TALUS_WRITE
  return c;
}

/** The label of a point. */
struct ReadLabel
{
  kernels::Map m;

  TALUS_HD PointLabel operator()(int point_i) const
  {
    int storage_i;
    return static_cast<PointLabel>(kernels::LabelPoint{m}.label(point_i, storage_i));
  }
};

struct ReadCell : HandOver
{
  TALUS_HD CellRecord operator()(int i) const
  {
    const Index at = index(i);
    return record_of(
        m.cell.load(at.storage_i), m.out.traversability[at.window_i], m.frame->offset_m);
  }
};

struct ReadChannels : HandOver
{
  TALUS_HD ChannelRecord operator()(int i) const
  {
    const int storage_i = index(i).storage_i;
    ChannelRecord r;
    for (int c = 0; c < m.channels.size; c++)
      for (int s = 0; s < kernels::kPointSurfaces; s++)
        r.values[kernels::Channel::at(c, s)] = kernels::shown_value(m, c, s, storage_i);
    return r;
  }
};

/** Writes the values that are not NaN into the map, where it has none. */
struct WriteChannels : HandOver
{
  TALUS_HD void operator()(int i, const ChannelRecord& r) const
  {
    const int storage_i = index(i).storage_i;
    for (int c = 0; c < m.channels.size; c++)
      for (int s = 0; s < kernels::kPointSurfaces; s++)
        m.channels.each[c].restore(
            kernels::Channel::at(storage_i, s), r.values[kernels::Channel::at(c, s)]);
  }
};

/** Writes the records that are not unknown into the map and its delivered layers. */
struct WriteCell : HandOver
{
  kernels::Layers shown;  //!< the delivered layers, in the caller's memory

  TALUS_HD void operator()(int i, const CellRecord& r) const
  {
    if (r.state == kernels::kUnknown) return;
    const Index at = index(i);
    m.cell.store(at.storage_i, cell_of(r, m.frame->offset_m));
    m.out.traversability[at.window_i] = r.traversability;
    kernels::PutSurface{m}.put(shown, at.window_i, at.storage_i);
    if (shown.traversability) shown.traversability[at.window_i] = r.traversability;
  }
};

}  // namespace talus
