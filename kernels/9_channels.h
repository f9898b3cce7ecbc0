#pragma once
#include "kernels/1_points.h"
#include "kernels/8_label.h"
#include "kernels/atomics.h"
#include "kernels/map.h"

namespace talus::kernels
{
// Channels: values of points, fused after stage 6. They decide nothing but where a class has a
// cost, see TakeClassScores. A point counts for the ground or the object, see surface_at().

/** Clears the channels of a cell that entered the window, as RollCell clears the cell. */
struct ForgetChannels
{
  const Map& m;

  TALUS_HD Stretch stays(int iy) const
  {
    return staying(*m.frame, m.k.cells, iy, m.frame->starts_map != 0);
  }
  TALUS_HD bool applies(int ix, int iy, int) const { return !stays(iy).has(ix); }
  TALUS_HD void operator()(int, int, int i) const
  {
    for (int c = 0; c < m.channels.size; c++)
      for (int surface = 0; surface < kPointSurfaces; surface++)
        m.channels.each[c].forget(Channel::at(i, surface));
  }
};

/** Whether the lowest surface of a cell is an object, and no ground was found below it. */
TALUS_HD bool is_object(int i, const Map& m)
{
  return m.surface_class[i] == kObject && m.cell.state[i] == kMeasured;
}

/** Finds the surface that a point belongs to, and adds its channels to it. */
template <class Atomics>
struct AssignPoint
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    int first = 0;
    const std::int32_t at = point_i < m.frame->n_points ? surface_of(point_i) : kNoSurface;
    for (int c = 0; c < m.channels.size && at >= 0; c++)
    {
      const Channel& channel = m.channels.each[c];
      if (channel.of_points && channel.template add<Atomics>(at, channel.of_points[point_i]))
        first |= 1 << c;
    }
    m.point_surface[point_i] = at;
    m.point_begins[point_i] = static_cast<std::uint8_t>(first);
  }

 private:
  TALUS_HD std::int32_t surface_of(int point_i) const
  {
    const int i = m.point_cell[point_i];
    if (i < 0) return kNoSurface;
    Cell c;  // all that separates ground and object from the rest
    c.ground_m = m.cell.ground_m[i];
    c.elevation_m = m.cell.elevation_m[i];
    c.driven_height = m.cell.driven_height[i];
    const float height_m = m.point_height_m[point_i] - m.frame->offset_m;
    const std::int32_t of_cell = surface_at(c, is_object(i, m), height_m, m.k);
    return of_cell == kNoSurface ? kNoSurface : Channel::at(i, of_cell);
  }
};

/** Fuses what the points of a frame added to the surfaces that the point began with what was known.
 * Where they show the ground and nothing stands, what stood there is forgotten. */
struct SettlePoint
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    const int begun = m.point_begins[point_i];
    for (int c = 0; c < m.channels.size && begun >> c != 0; c++)
      if (begun >> c & 1) settle(m.channels.each[c], m.point_surface[point_i]);
  }

 private:
  TALUS_HD void settle(const Channel& channel, std::int32_t surface) const
  {
    channel.settle(surface);
    const int i = surface / kPointSurfaces;
    if (surface % kPointSurfaces == kOfGround &&
        !has_object(m.cell.ground_m[i], m.cell.elevation_m[i], m.k))
      channel.forget(Channel::at(i, kOfObject));
  }
};

/** What the map shows of a channel; NaN where it has no such surface. */
TALUS_HD float shown_value(const Map& m, int channel, int surface, int i)
{
  const bool there =
      surface == kOfObject
          ? has_object(m.cell.ground_m[i], m.cell.elevation_m[i], m.k) || is_object(i, m)
          : m.cell.state[i] != kUnknown;
  return select(there, m.channels.each[channel].values[Channel::at(i, surface)].value, kNan);
}

/** Copies a channel of one surface to window order. */
struct PutChannel
{
  const Map& m;

  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    m.put.out[m.window_at(ix, iy)] = shown_value(m, m.put.channel, m.put.surface, i);
  }
};

/** The traversability of a cell that was judged is the minimum of the map's score and those of its
 * classes. Nowhere else do channels decide. */
struct TakeClassScores
{
  const Map& m;

  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    float& score = m.out.traversability[m.window_at(ix, iy)];
    for (int c = 0; c < m.channels.size; c++)
      for (int s = 0; s < kPointSurfaces && m.channels.each[c].rule == kVote; s++)
      {
        const float value = shown_value(m, c, s, i);
        if (!(value >= 0.0f)) continue;  // also NaN
        const int of_class = c * kClasses + (static_cast<int>(value) & (kClasses - 1));
        if (m.class_scores[of_class] < score)
          score = m.class_scores[of_class];  // not if not judged
      }
  }
};

}  // namespace talus::kernels
