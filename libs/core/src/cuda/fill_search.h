#pragma once
#include "kernels/6_fill.h"
#include "kernels/7_sparsity.h"

namespace talus::kernels
{
// How a device finds the samples of stage 6. Every line, row and column keeps one bit for each
// cell, "measured ground here", so that a bit scan finds the next sample.

TALUS_HD int words_per_axis(const Config& k) { return (k.cells + 31) / 32; }
TALUS_HD int words_per_line(const Config& k) { return line_rings(k) / 32 + 1; }

TALUS_HD int lowest_bit(std::uint64_t bits)
{
#if defined(__CUDA_ARCH__)
  return __ffsll(static_cast<long long>(bits)) - 1;
#else
  return __builtin_ctzll(bits);
#endif
}

TALUS_HD std::uint32_t reverse_bits(std::uint32_t bits)
{
#if defined(__CUDA_ARCH__)
  return __brev(bits);
#else
  std::uint32_t reversed = 0;
  for (int b = 0; b < 32; b++) reversed |= (bits >> b & 1u) << (31 - b);
  return reversed;
#endif
}

/** Marks of a line: bit r % 32 of word r / 32 is cell r; kGuardWords at both ends are unmarked. */
struct LineMarks
{
  const std::uint32_t* word0;
  int stride;  //!< between words

  static constexpr int kView = 64, kGuardWords = 2;

  /** The marks at distances (from, from + kView] on one side of an index; the nearest is bit 0. The
   * first of them must be on the line. */
  TALUS_HD std::uint64_t view(int index, bool outwards, int from) const
  {
    const int first = outwards ? index + from + 1 : index - from - 1;
    const int skipped = outwards ? first & 31 : 31 - (first & 31), next = outwards ? 1 : -1;
    const int at = first >> 5;
    const std::uint64_t a = word(at, outwards), b = word(at + next, outwards),
                        c = word(at + 2 * next, outwards);
    const std::uint64_t low = static_cast<std::uint32_t>((a | b << 32) >> skipped);
    const std::uint64_t high = static_cast<std::uint32_t>((b | c << 32) >> skipped);
    return low | high << 32;
  }
  /** Distance to the nearest marked cell; 0: none within reach, which must end on the line. */
  TALUS_HD int nearest(int index, bool outwards, int cells_to_end) const
  {
    for (int from = 0; from < cells_to_end; from += kView)
      if (const std::uint64_t bits = view(index, outwards, from))
      {
        const int found = from + 1 + lowest_bit(bits);
        return found <= cells_to_end ? found : 0;
      }
    return 0;
  }

 private:
  TALUS_HD std::uint64_t word(int at, bool outwards) const
  {
    const std::uint32_t bits = word0[at * stride];
    return outwards ? bits : reverse_bits(bits);
  }
};

struct CellOffset
{
  int dx, dy;
};

/** A line from the sensor on the grid, index = ring, and how far fills search it. */
struct Track
{
  int begin, along;  //!< index 0, and the stride to the next index
  int across;  //!< stride to the next row of cells
  int minor, rings;  //!< it shifts minor / rings rows for each ring, rounded
  float inverse;  //!< 1 / (2 rings)
  float cell_m;  //!< length in each cell
  int fill_cells, sparsity_cells;  //!< that fills and stage 7 search

  TALUS_HD int operator()(int index) const
  {
    return begin + index * along + aside_at(index) * across;
  }
  /** Cell at an index, relative to the sensor's cell. */
  TALUS_HD CellOffset offset(int index) const
  {
    const int ahead = along > 0 ? index : -index;
    const int aside = across > 0 ? aside_at(index) : -aside_at(index);
    return abs_of(along) == 1 ? CellOffset{ahead, aside} : CellOffset{aside, ahead};
  }
  TALUS_HD int aside_at(int index) const { return line_aside(minor, index, rings, inverse); }
  TALUS_HD int last() const { return rings; }
};

/** A row or a column; index = ix or iy. */
struct AxisTrack
{
  int begin, along, cells;
  float cell_m;
  int fill_cells;

  TALUS_HD int operator()(int index) const { return begin + index * along; }
  TALUS_HD int last() const { return cells - 1; }
};

TALUS_HD Track radial_track(const Line& l, const LineGrid& grid, const Config& k)
{
  const bool along_x = l.side % 2 == 0;
  const int sign = l.side < 2 ? 1 : -1, rings = grid.half;
  const float cell_m = line_stretch(l, rings) * k.resolution_m;
  return {
      grid.middle(),
      along_x ? sign : sign * grid.pitch,
      along_x ? sign * grid.pitch : -sign,
      l.minor,
      rings,
      1.0f / static_cast<float>(2 * rings),
      cell_m,
      cells_in(k.fill_search_m, cell_m, rings),
      cells_in(k.sparsity_search_m, cell_m, rings)};
}

/** Makes the constant data of the lines from the sensor. */
struct FillLineTables
{
  const Map& m;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int rings = m.lines.half, dx = ix - rings, dy = iy - rings;
    if (dx == 0 && dy == 0) return;
    const int ring = max_of(abs_of(dx), abs_of(dy));
    const int index = line_index(line_through(dx, dy, ring, rings), rings);
    m.line_of_cell[m.lines.at(ix, iy)] = index;
    if (ring == rings) m.track[index] = radial_track(line_from_index(index, rings), m.lines, m.k);
  }
};

/** Whether cells of a line are samples, from the marks of rows and columns: less than the cells. */
struct SamplesOfLine
{
  const Map& m;

  TALUS_HD bool operator()(int line, int ring) const
  {
    const Track& track = m.track[line];
    const CellOffset at = track.offset(ring);
    const int n = m.k.cells, ix = track.rings + at.dx, iy = track.rings + at.dy;
    // With an even number of cells, lines end one cell beyond the window.
    return iy < n && m.axis_marks[(ix >> 5) * 2 * n + iy] >> (ix & 31) & 1u;
  }
};

template <class Line>
struct LineSearch
{
  const Map& m;
  LineMarks marks;
  Line track;
  int index;

  /** `cells`, or less where the line ends. */
  TALUS_HD int cells_to_end(bool outwards, int cells) const
  {
    return min_of(cells, outwards ? track.last() - index : index);
  }
  TALUS_HD int at(bool outwards, int distance) const
  {
    return track(outwards ? index + distance : index - distance);
  }
  TALUS_HD int nearest(bool outwards, int cells) const
  {
    return marks.nearest(index, outwards, cells_to_end(outwards, cells));
  }

  TALUS_HD SideEstimate infer_side(bool outwards) const
  {
    const int limit = cells_to_end(outwards, track.fill_cells);
    SideSum sum;
    float nearest = kNan;
    int nearest_cells = 0, wanted = m.k.fill_samples;
    for (int from = 0; from < limit && wanted > 0; from += LineMarks::kView)
    {
      std::uint64_t bits = marks.view(index, outwards, from);
      int found[kBatch];
      do
      {
        for (int b = 0; b < kBatch; b++, bits &= bits - 1)
        {
          found[b] = bits && b < wanted ? from + 1 + lowest_bit(bits) : 0;
          if (found[b] > limit) found[b] = 0;
        }
        if (!found[0]) break;
        // The loads come first, so that they do not wait for each other.
        float height[kBatch];
        for (int b = 0; b < kBatch; b++)
          height[b] = found[b] ? m.sample_m[at(outwards, found[b])] : 0.0f;
        if (!nearest_cells) nearest = height[0], nearest_cells = found[0];
        for (int b = 0; b < kBatch; b++)
        {
          const float away_m = static_cast<float>(found[b]) * track.cell_m;
          sum.add(height[b], found[b] ? away_m : kOutOfReach_m, m.k);
          wanted -= found[b] > 0;
        }
      } while (found[kBatch - 1] && wanted > 0);
    }
    const int far = nearest_cells ? 0 : this->nearest(outwards, track.last());
    if (far) nearest = m.sample_m[at(outwards, far)];
    const float nearest_away_m = static_cast<float>(nearest_cells + far) * track.cell_m;
    return nearest_cells + far ? sum.estimate(nearest, nearest_cells, nearest_away_m) : none();
  }

 private:
  static constexpr int kBatch = 2;

  /** An estimate without samples. Its values avoid a division by zero, which would be slow. */
  static TALUS_HD SideEstimate none()
  {
    SideEstimate side;
    side.distance_m = side.mean_distance_m = 1.0f;
    return side;
  }
};

/** Searches the lines through cell (ix, iy) and fills it: the line from the sensor, the column and
 * the row. Their sides, and what is behind, may be searched in parallel or in turn. */
struct SearchAndFillCell
{
  static constexpr int kLines = 3;
  using Side = SideEstimate;
  using Line = LineFusion;
  struct Behind
  {
    std::int32_t cells = 0;  //!< to the nearest sample; 0: none
    Gap gap;  //!< near the robot
  };
  const Map& m;

  TALUS_HD SideEstimate side(int line, bool outwards, int ix, int iy) const
  {
    return wanted(ix, iy) ? infer_side(line, outwards, ix, iy) : SideEstimate{};
  }
  TALUS_HD Behind behind(int ix, int iy) const
  {
    return wanted(ix, iy) ? look_behind(radial_search(ix, iy)) : Behind{};
  }
  static TALUS_HD LineFusion line(const SideEstimate& inner, const SideEstimate& outer)
  {
    return fuse_sides(inner, outer);
  }
  /** Fills the cell from the sides of the first line, what is behind, and the sums of all lines. */
  TALUS_HD void operator()(
      int ix, int iy, const SideEstimate& inner, const SideEstimate& outer, const Behind& behind,
      const LineFusion* lines, int stride) const
  {
    Inferred found;
    found.lines.information = 1.0f;  // avoids a division by zero
    if (inner.near() || outer.near())
    {
      found = beside_sensor(radial_search(ix, iy), ix, iy, inner, outer, behind, lines[0]);
      for (int l = 1; l < kLines; l++) found.lines.add(lines[l * stride]);
    }
    finish(ix, iy, found);
  }

  /** Searches in turn: if the first line has no sample, the others are skipped. */
  TALUS_HD void operator()(int ix, int iy) const
  {
    const SideEstimate inner = side(0, false, ix, iy), outer = side(0, true, ix, iy);
    LineFusion lines[kLines];
    Behind behind;
    if (inner.near() || outer.near())
    {
      lines[0] = line(inner, outer);
      for (int l = 1; l < kLines; l++)
        lines[l] = line(infer_side(l, false, ix, iy), infer_side(l, true, ix, iy));
      behind = look_behind(radial_search(ix, iy));
    }
    (*this)(ix, iy, inner, outer, behind, lines, 1);
  }

 private:
  /** The sensor's own cell lies on no line. */
  TALUS_HD bool wanted(int ix, int iy) const
  {
    return (ix != m.lines.half || iy != m.lines.half) && FillCell{m}.wanted(m.at(ix, iy));
  }
  TALUS_HD SideEstimate infer_side(int line, bool outwards, int ix, int iy) const
  {
    return line == 0 ? radial_search(ix, iy).infer_side(outwards)
                     : axis_search(ix, iy, line == 2).infer_side(outwards);
  }

  struct Inferred
  {
    LineFusion lines;
    std::int32_t marks = 0;  //!< bits of FillMark
  };

  TALUS_HD void finish(int ix, int iy, const Inferred& found) const
  {
    const int i = m.at(ix, iy), state = FillCell{m}(ix, iy, i, found.lines, found.marks);
    if (state != kMeasured && !(found.marks & kInferred)) m.fall_m[m.lines.at(ix, iy)] = kNan;
    PutSurface{m}(ix, iy, i);
  }

  TALUS_HD LineSearch<Track> radial_search(int ix, int iy) const
  {
    const int line = m.line_of_cell[m.lines.at(ix, iy)], rings = m.lines.half;
    const int ring = max_of(abs_of(ix - rings), abs_of(iy - rings));
    return {m, {m.marks + line, 8 * rings}, m.track[line], ring};
  }

  TALUS_HD LineSearch<AxisTrack> axis_search(int ix, int iy, bool along_x) const
  {
    const int n = m.k.cells, begin = along_x ? m.lines.at(0, iy) : m.lines.at(ix, 0);
    return {
        m,
        {m.axis_marks + (along_x ? iy : n + ix), 2 * n},
        {begin, along_x ? 1 : m.lines.pitch, n, m.k.resolution_m,
         cells_in(m.k.fill_search_m, m.k.resolution_m, n - 1)},
        along_x ? ix : iy};
  }

  TALUS_HD Inferred beside_sensor(
      const LineSearch<Track>& radial, int ix, int iy, const SideEstimate& inner,
      const SideEstimate& outer, const Behind& behind, const LineFusion& lines) const
  {
    const float robot_m = robot_away_m(radial);
    const bool asks = inner.near() && !outer.near() && !behind.cells;
    Inferred found{lines, marks_of_sides(inner, outer, asks && drops_ahead(radial, inner))};
    const float fall_m = estimate_fall(behind.gap, robot_m, found.marks, m.k);
    if (robot_m <= m.k.sparsity_range_m) m.fall_m[m.lines.at(ix, iy)] = fall_m;
    return found;
  }
  TALUS_HD float robot_away_m(const LineSearch<Track>& radial) const
  {
    return static_cast<float>(radial.index) * radial.track.cell_m;
  }
  TALUS_HD Behind look_behind(const LineSearch<Track>& radial) const
  {
    Behind found;
    found.cells = radial.nearest(true, radial.track.sparsity_cells);
    if (robot_away_m(radial) <= m.k.sparsity_range_m) found.gap = gap_to(radial, found.cells);
    return found;
  }
  /** For a cell with samples towards the sensor only. */
  TALUS_HD bool drops_ahead(const LineSearch<Track>& radial, const SideEstimate& inner) const
  {
    const int last = radial.index + radial.cells_to_end(true, radial.track.fill_cells);
    const int first =
        (radial.index + kDropStride_cells - 1) / kDropStride_cells * kDropStride_cells;
    const int sample = radial.index - inner.cells;
    bool any = false;
    const Track& track = radial.track;
    for (int index = first; index <= last && !any; index += kDropStride_cells)
    {
      const float away_m = static_cast<float>(index - sample) * track.cell_m;
      const float* const free_m = m.free_above_m + track.begin + index * track.along;
      any = ends_below_ground(m.ends_m[track(index)], inner.nearest_m, away_m) &&
            !is_passed_over(
                free_m, track.across, track.aside_at(index), track.rings, inner.nearest_m);
    }
    return any;
  }
  /** From the sample before to that `behind` cells behind. */
  TALUS_HD Gap gap_to(const LineSearch<Track>& radial, int behind) const
  {
    const int before = radial.nearest(false, radial.track.sparsity_cells);
    if (!before || !behind) return {};
    const LineSearch<Track> far{m, radial.marks, radial.track, radial.index + behind};
    const int next = far.nearest(true, radial.track.last());
    const int far_i = radial.at(true, behind);
    return {
        static_cast<float>(before + behind) * radial.track.cell_m,
        m.sample_m[radial.at(false, before)], m.sample_m[far_i],
        next ? m.sample_m[far.at(true, next)] : kNan,
        static_cast<float>(next) * radial.track.cell_m};
  }
};

}  // namespace talus::kernels
