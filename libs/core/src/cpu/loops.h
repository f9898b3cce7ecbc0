#pragma once
#include "cpu/buffer.h"
#include "cpu/side_by_side.h"
#include "kernels/map.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

namespace talus
{
/** f(i) for i in [begin, end) in whole blocks; true if there is at least one. */
template <int kBlock, class F>
bool in_blocks_of(int begin, int end, const F& f)
{
  const int blocks = (end - begin) / kBlock, whole = begin + blocks * kBlock;
  if (blocks == 0) return false;
  TALUS_INDEPENDENT
  for (int i = begin; i < whole; i++) f(i);
  if (whole < end)
  {
    TALUS_INDEPENDENT
    for (int i = end - kBlock; i < end; i++) f(i);
  }
  return true;
}
/** f(i) for i in [begin, end), for some twice, as the last block overlaps the one before. */
template <class F>
void in_blocks(int begin, int end, const F& f)
{
  if (in_blocks_of<32>(begin, end, f) || in_blocks_of<16>(begin, end, f)) return;
  for (int i = begin; i < end; i++) f(i);
}

// Loops have a copy of the map that nothing else can write to, so that they need not read it again.

/** A rule for x in [begin, end) of a row, storage indices from `first` on; perhaps twice. */
template <class Rule>
TALUS_CLONES void over_row(const kernels::Map& map, int begin, int end, int y, int first)
{
  const kernels::Map m = map;
  const Rule rule{m};
  in_blocks(begin, end, [&](int x) { rule(x, y, first + (x - begin)); });
}

/** Marks the cells of a row to which a rule applies. */
template <class Rule>
TALUS_CLONES void find_applicable(
    const kernels::Map& map, int begin, int end, int y, int first, std::uint8_t* applicable)
{
  const kernels::Map m = map;
  const Rule f{m};
  in_blocks(
      begin, end, [&](int x) { applicable[x - begin] = f.applies(x, y, first + (x - begin)); });
}
/** Marks of cells, looked at in groups. */
template <int kMax>
struct Marks
{
  static constexpr int kGroup = 8;
  alignas(64) std::uint8_t of[kMax + kGroup];
};
/** f(i) for the marked i below n; marks are few. */
template <int kMax, class F>
void over_marked(Marks<kMax>& m, int n, const F& f)
{
  constexpr int kGroup = Marks<kMax>::kGroup;
  std::uint8_t* const marks = m.of;
  std::memset(marks + n, 0, kGroup);
  for (int block = 0; block < n; block += kGroup)
  {
    std::uint64_t any;
    std::memcpy(&any, marks + block, kGroup);
    if (any == 0) continue;
    for (int i = block; i < std::min(block + kGroup, n); i++)
      if (marks[i]) f(i);
  }
}
template <class Rule>
void for_each_applicable(const kernels::Map& m, int begin, int end, int y, int first)
{
  const Rule rule{m};
  constexpr int kBlock = 256;
  Marks<kBlock> applicable;
  for (int x0 = begin; x0 < end; x0 += kBlock)
  {
    const int x1 = std::min(x0 + kBlock, end), shift = first - begin;
    find_applicable<Rule>(m, x0, x1, y, x0 + shift, applicable.of);
    over_marked(applicable, x1 - x0, [&](int i) { rule(x0 + i, y, x0 + i + shift); });
  }
}

template <class Rule, class = void>
constexpr bool kLeavesRowsOut = false;
template <class Rule>
constexpr bool kLeavesRowsOut<Rule, std::void_t<decltype(&Rule::leaves_out)>> = true;
template <class Rule, class = void>
constexpr bool kLeavesStretch = false;
template <class Rule>
constexpr bool kLeavesStretch<Rule, std::void_t<decltype(&Rule::stays)>> = true;

/** A row of the window and its storage: two ranges of a torus. Loops over the same cells take a row
 * each, so that its cells are still in the cache. */
class StoredRow
{
 public:
  StoredRow(const kernels::Map& m, int y)
      : m_(m), y_(y), turn_(m.k.cells - m.frame->storage_x), row_(m.at(0, y) - m.frame->storage_x)
  {
  }
  /** A rule on all cells to which it applies; perhaps twice. */
  template <class Rule>
  void run() const
  {
    if constexpr (kLeavesRowsOut<Rule>)
      if (Rule{m_}.leaves_out(y_)) return;
    if constexpr (kLeavesStretch<Rule>)
    {
      const kernels::Stretch stays = Rule{m_}.stays(y_);
      run<Rule>(0, stays.first);
      run<Rule>(stays.end, m_.k.cells);
    }
    else if constexpr (kernels::kHasApplies<Rule>)
      in_stretches([&](int begin, int end, int i)
                   { for_each_applicable<Rule>(m_, begin, end, y_, i); });
    else
      in_stretches([&](int begin, int end, int i) { over_row<Rule>(m_, begin, end, y_, i); });
  }
  /** A rule on all of the cells [first, last). */
  template <class Rule>
  void run(int first, int last) const
  {
    in_stretches(
        [&](int begin, int end, int i)
        {
          const int from = std::max(begin, first), to = std::min(end, last);
          if (from < to) over_row<Rule>(m_, from, to, y_, i + from - begin);
        });
  }
  /** over(begin, end, i), i the storage index of the cell at `begin`. */
  template <class Over>
  void in_stretches(const Over& over) const
  {
    over(0, turn_, row_ + m_.k.cells - turn_);
    over(turn_, m_.k.cells, row_);
  }

 private:
  const kernels::Map& m_;
  int y_, turn_, row_;
};

/** Cells of a row with different numbers of rays: adds one ray to several neighbours at once. */
template <class F>
class RowOfRays
{
  using Item = typename F::Item;
  using Result = typename F::Result;
  static constexpr int kLanes = 128, kGroup = 32;
  using Items = SideBySide<Item, kLanes>;
  using Results = SideBySide<Result, kLanes>;

 public:
  void run(const kernels::Map& m, int y)
  {
    for (int x0 = 0; x0 < m.k.cells; x0 += kLanes)
    {
      const int x1 = std::min(x0 + kLanes, m.k.cells);
      add(m, items_, results_, x0, y, (x1 - x0 + kGroup - 1) / kGroup);
      put(m, items_, results_, x0, x1, y);
    }
  }

 private:
  /** Adds the rays of the cells from x on, in whole groups, which may reach beyond the row. */
  TALUS_CLONES static void add(
      const kernels::Map& map, Items& items, Results& results, int x, int y, int blocks)
  {
    const kernels::Map m = map;
    const F f{m};
    const Result none;
    TALUS_INDEPENDENT
    for (int l = 0; l < blocks * kGroup; l++)
    {
      items.store(l, f.item(x + l, y));
      results.store(l, none);
    }
    for (int first = 0; first < blocks * kGroup; first += kGroup)
    {
      int rays = 0;
      for (int l = first; l < first + kGroup; l++) rays = std::max(rays, f.rays(items.load(l)));
      for (int which = 0; which < rays; which++)
      {
        TALUS_INDEPENDENT
        for (int l = first; l < first + kGroup; l++)
        {
          Result result = results.load(l);
          f.add(result, items.load(l), which);
          results.store(l, result);
        }
      }
    }
  }
  TALUS_CLONES static void put(
      const kernels::Map& map, const Items& items, const Results& results, int x0, int x1, int y)
  {
    const kernels::Map m = map;
    const F f{m};
    in_blocks(x0, x1, [&](int x) { f.put(x, y, items.load(x - x0), results.load(x - x0)); });
    if (m.frame->starts_map != 0)
      for (int x = x0; x < x1; x++) f.put_lowest(x, y, items.load(x - x0));
  }

  Items items_;
  Results results_;
};

/** Pools cells two by two, by the parity of their index in the map: f.item(i) of each. */
template <class F>
class PairOfRows
{
  using Item = typename F::Item;
  static constexpr int kLanes = 512;
  using Items = SideBySide<Item, kLanes>;

 public:
  void pool(const kernels::Map& m, int py)
  {
    const int cells = m.k.cells, y0 = m.pairs.first_cell(py, m.frame->odd_y);
    const int first = std::max(y0, 0), end = std::min(y0 + 2, cells);
    for (int px = 0; px < m.pairs.side; px += kLanes / 2)
    {
      const int pairs = std::min(m.pairs.side - px, kLanes / 2), lanes = 2 * pairs;
      const int x0 = m.pairs.first_cell(px, m.frame->odd_x);
      forget(0, first < end ? -x0 : lanes);
      forget(std::max(cells - x0, 0), lanes);
      if (first < end) add<true>(m, first, x0);
      if (first + 1 < end) add<false>(m, first + 1, x0);
      put(m, items_, pairs, px, py);
    }
  }

 private:
  /** Clears lanes outside of the window. */
  void forget(int begin, int end)
  {
    for (int l = begin; l < end; l++) items_.store(l, {});
  }
  /** Adds the cells of a row; those of the first one are stored. */
  template <bool kFirst>
  void add(const kernels::Map& m, int y, int x0)
  {
    StoredRow(m, y).in_stretches(
        [&](int begin, int end, int i)
        {
          const int from = std::max(begin, x0), to = std::min(end, x0 + kLanes);
          if (from < to) add<kFirst>(m, items_, from - x0, to - x0, i + from - begin);
        });
  }
  template <bool kFirst>
  TALUS_CLONES static void add(const kernels::Map& map, Items& items, int begin, int end, int first)
  {
    const kernels::Map m = map;
    const F f{m};
    const auto add_one = [&](int l)
    {
      const Item item = f.item(first + (l - begin));
      items.store(l, kFirst ? item : f.pool(items.load(l), item));
    };
    in_blocks(begin, end, add_one);
  }
  TALUS_CLONES static void put(
      const kernels::Map& map, const Items& items, int pairs, int px, int py)
  {
    const kernels::Map m = map;
    const F f{m};
    TALUS_INDEPENDENT
    for (int q = 0; q < pairs; q++)
      f.put(px + q, py, f.pool(items.load(2 * q), items.load(2 * q + 1)));
  }

  Items items_;
};

template <class T>
TALUS_CLONES void fill_with(T* to, int begin, int end, T value)
{
  for (int i = begin; i < end; i++) to[i] = value;
}

template <class F>
TALUS_CLONES void over_stretch(const kernels::Map& map, int first, int last)
{
  const kernels::Map m = map;
  F{m}(first, last);
}

template <class F>
TALUS_CLONES void locate_points(const kernels::Map& map, int begin, int end)
{
  kernels::Map m = map;
  kernels::FrameContext frame = *map.frame;
  m.frame = &frame;
  const F f{m};
  TALUS_INDEPENDENT
  for (int i = begin; i < end; i++) f.locate_plain(i);
  for (int box = 0; box < m.body->boxes; box++)
  {
    TALUS_INDEPENDENT
    for (int i = begin; i < end; i++) f.drop_body(i, m.in.at(i), box);
  }
  f.count_rejected(begin, end);
}
template <class F>
void over_points(const kernels::Map& m, int begin, int end)
{
  const F f{m};
  if (f.is_plain())
  {
    locate_points<F>(m, begin, end);
    return;
  }
  for (int i = begin; i < end; i++) f.locate(i, m.in.at(i));
  f.count_rejected(begin, end);
}

/** Lists the points of a part, in their order. */
template <class F>
TALUS_CLONES void find_own(
    const kernels::Map& map, int begin, int end, int part, int parts, std::int32_t* own)
{
  const kernels::Map m = map;
  const F f{m};
  const auto own_part = f.part(part, parts);
  TALUS_INDEPENDENT
  for (int i = begin; i < end; i++) own[i - begin] = f.is_in(own_part, i);
}
template <class F>
void over_own_points(const kernels::Map& m, int n, int part, int parts)
{
  const F f{m};
  constexpr int kBlock = 512;
  for (int i0 = 0; i0 < n; i0 += kBlock)
  {
    const int i1 = std::min(i0 + kBlock, n);
    std::int32_t is_own[kBlock];
    find_own<F>(m, i0, i1, part, parts, is_own);
    int own[kBlock], found = 0;
    for (int i = i0; i < i1; i++)
    {
      own[found] = i;
      found += is_own[i - i0];
    }
    for (int j = 0; j < found; j++) f(own[j]);
  }
}

/** Sorts points into cells. The ray of a point's own direction rules most out as overhangs. */
template <class F>
TALUS_CLONES void find_passed_below(
    const kernels::Map& map, int begin, int end, std::int32_t* passed_below)
{
  const kernels::Map m = map;
  const F f{m};
  TALUS_INDEPENDENT
  for (int i = begin; i < end; i++) passed_below[i - begin] = f.passed_below(i, 0);
}
template <class F>
void sort_points(const kernels::Map& m, int begin, int end)
{
  const F f{m};
  constexpr int kBlock = 512;
  std::int32_t passed_below[kBlock];
  for (int i0 = begin; i0 < end; i0 += kBlock)
  {
    const int i1 = std::min(i0 + kBlock, end);
    find_passed_below<F>(m, i0, i1, passed_below);
    for (int i = i0; i < i1; i++) f.put(i, passed_below[i - i0] && f.overhangs(i));
  }
}

/** Sums over the square neighbourhoods of the cells in a strip of columns, row by row. F::Row is
 * summed once for each row, F::Window slides along. F::kHasPlain: f.write_unjudged() does groups
 * without f.needs_features(), f.plain() most others, then f.finish() those which f.applies(). */
template <class F>
class SlidingRows
{
  using Row = typename F::Row;
  using Window = typename F::Window;
  static constexpr int kLanes = 128;
  using Rows = SideBySide<Row, kLanes>;
  using Windows = SideBySide<Window, kLanes>;
  static constexpr int kAtOnce = 5;  //!< neighbours added in one pass
  static constexpr int kGroup = 32;  //!< cells finished together
  static constexpr int kAhead = 8;  //!< rows fetched before they are added
  template <int n>
  using Distances = std::make_integer_sequence<int, n>;
  /** The first distance of five cells, the default. Compilers know products with it. */
  using FirstOfFive = std::integral_constant<int, -(kAtOnce / 2)>;

 public:
  SlidingRows(const kernels::Map& m, int nx, int ny, int radius)
      : m_(m), nx_(nx), ny_(ny), radius_(radius)
  {
    while (mask_ < 2 * radius) mask_ = 2 * mask_ + 1;
    // Memory of this thread, kept from frame to frame.
    static thread_local std::vector<Rows, CellMemory<Rows>> rows;
    const auto size = static_cast<std::size_t>(mask_ + 1);
    if (rows.size() < size) rows.resize(size);
    rows_ = rows.data();
  }

  void run(int begin, int end) const
  {
    for (int x = 0; x < nx_; x += kLanes) run(x, std::min(x + kLanes, nx_), begin, end);
  }

 private:
  void run(int x0, int x1, int begin, int end) const
  {
    int next = std::max(begin - radius_, 0);
    for (int y = begin; y < end; y++)
    {
      for (; next <= std::min(y + radius_, ny_ - 1); next++)
      {
        if (nx_ > 2 * kLanes) fetch(x0, x1, std::min(next + kAhead, ny_ - 1));
        sum_row(m_, at(next), x0, x1, next, radius_);
      }
      window(y, x0, x1);
    }
  }

  /** Fetches a row early, for a strip is too narrow for a processor to predict it. */
  TALUS_FETCHES void fetch(int x0, int x1, int y) const
  {
    const F f{m_};
    constexpr auto kStep = static_cast<int>(64 / sizeof(f.neighbour(0, 0)));
    for (int x = x0; x < x1; x += kStep) __builtin_prefetch(&f.neighbour(x, y));
  }
  static void sum_row(const kernels::Map& m, Rows& rows, int x0, int x1, int y, int radius)
  {
    int d = -radius;
    if (d == FirstOfFive::value)
    {
      add_columns<true>(m, rows, x0, x1, y, FirstOfFive{}, Distances<kAtOnce>{});
      d += kAtOnce;
    }
    else if (2 * radius + 1 < kAtOnce)
      add_columns<true>(m, rows, x0, x1, y, d++, Distances<1>{});
    else
    {
      add_columns<true>(m, rows, x0, x1, y, d, Distances<kAtOnce>{});
      d += kAtOnce;
    }
    for (; d + kAtOnce - 1 <= radius; d += kAtOnce)
      add_columns<false>(m, rows, x0, x1, y, d, Distances<kAtOnce>{});
    for (; d <= radius; d++) add_columns<false>(m, rows, x0, x1, y, d, Distances<1>{});
  }
  /** Adds the neighbours at distances from d on; the first ones are stored. */
  template <bool kFirst, class Distance, int... k>
  TALUS_CLONES static void add_columns(
      const kernels::Map& map, Rows& rows, int x0, int x1, int y, Distance d,
      std::integer_sequence<int, k...>)
  {
    const kernels::Map m = map;
    const F f{m};
    TALUS_INDEPENDENT
    for (int x = x0; x < x1; x++)
    {
      Row row = kFirst ? Row{} : rows.load(x - x0);
      (f.add(row, x, y, d + k), ...);
      rows.store(x - x0, row);
    }
  }

  void window(int y, int x0, int x1) const
  {
    Windows sums;
    if constexpr (F::kHasPlain)
    {
      if (const std::uint32_t needed = write_unjudged(m_, x0, x1, y))
      {
        const int groups = 32 - __builtin_clz(needed);
        sum_rows(sums, y, std::min(groups * kGroup, x1 - x0));
        finish(m_, sums, x0, x1, y, needed);
      }
      Marks<kLanes> applicable;
      find_applicable(m_, sums, x0, x1, y, applicable.of);
      over_marked(applicable, x1 - x0, [&](int l) { F{m_}.finish(x0 + l, y, sums.load(l)); });
    }
    else
    {
      sum_rows(sums, y, x1 - x0);
      finish(m_, sums, x0, x1, y, 0);
    }
  }
  void sum_rows(Windows& sums, int y, int lanes) const
  {
    const int last = std::min(y + radius_, ny_ - 1);
    int row = std::max(y - radius_, 0);
    const auto add_five = [&](auto first, auto distance)
    {
      add_rows<first>(
          m_, sums, lanes, distance, at(row), at(row + 1), at(row + 2), at(row + 3), at(row + 4));
      row += kAtOnce;
    };
    if (last - row + 1 < kAtOnce)
      add_rows<true>(m_, sums, lanes, row - y, at(row)), row++;
    else if (row - y == FirstOfFive::value)
      add_five(std::true_type{}, FirstOfFive{});
    else
      add_five(std::true_type{}, row - y);
    while (row + kAtOnce - 1 <= last) add_five(std::false_type{}, row - y);
    for (; row <= last; row++) add_rows<false>(m_, sums, lanes, row - y, at(row));
  }
  /** A bit for each group in which a cell needs features. Stores the result of the others. */
  TALUS_CLONES static std::uint32_t write_unjudged(const kernels::Map& map, int x0, int x1, int y)
  {
    const kernels::Map m = map;
    const F f{m};
    std::uint32_t groups = 0;
    for (int begin = x0; begin < x1; begin += kGroup)
    {
      const int end = std::min(begin + kGroup, x1);
      int needs = 0;
      TALUS_INDEPENDENT
      for (int x = begin; x < end; x++) needs |= f.needs_features(x, y);
      if (needs)
        groups |= 1u << ((begin - x0) / kGroup);
      else
      {
        TALUS_INDEPENDENT
        for (int x = begin; x < end; x++) f.write_unjudged(x, y);
      }
    }
    return groups;
  }
  /** Adds rows at distances from d on; the first ones are stored. */
  template <bool kFirst, class Distance, class... Each>
  TALUS_CLONES static void add_rows(
      const kernels::Map& map, Windows& sums, int lanes, Distance d, const Each&... rows)
  {
    const kernels::Map m = map;
    const F f{m};
    TALUS_INDEPENDENT
    for (int l = 0; l < lanes; l++)
    {
      Window sum = kFirst ? Window{} : sums.load(l);
      int distance = d;
      (f.add(sum, rows.load(l), distance++), ...);
      sums.store(l, sum);
    }
  }
  TALUS_CLONES static void finish(
      const kernels::Map& map, const Windows& sums, int x0, int x1, int y, std::uint32_t needed)
  {
    const kernels::Map m = map;
    const F f{m};
    if constexpr (F::kHasPlain)
    {
      for (int x = x0; x < x1; x += kGroup, needed >>= 1)
        if (needed & 1u) finish_block(f, sums, x0, x, std::min(x + kGroup, x1), y);
    }
    else
    {
      TALUS_INDEPENDENT
      for (int x = x0; x < x1; x++) f(x, y, sums.load(x - x0));
    }
  }
  /** Marks the cells that f.finish() may change afterwards. */
  TALUS_CLONES static void find_applicable(
      const kernels::Map& map, const Windows& sums, int x0, int x1, int y, std::uint8_t* applicable)
  {
    const kernels::Map m = map;
    const F f{m};
    TALUS_INDEPENDENT
    for (int x = x0; x < x1; x++) applicable[x - x0] = f.applies(x, y, sums.load(x - x0));
  }
  /** Uses f.plain() if that will do for all of them. */
  static void finish_block(const F& f, const Windows& sums, int x0, int begin, int end, int y)
  {
    int other = 0;
    TALUS_INDEPENDENT
    for (int x = begin; x < end; x++) other |= !f.is_plain(sums.load(x - x0));
    if (other)
    {
      TALUS_INDEPENDENT
      for (int x = begin; x < end; x++) f(x, y, sums.load(x - x0));
    }
    else
    {
      TALUS_INDEPENDENT
      for (int x = begin; x < end; x++) f.plain(x, y, sums.load(x - x0));
    }
  }

  Rows& at(int y) const { return rows_[y & mask_]; }

  const kernels::Map& m_;
  int nx_, ny_, radius_, mask_ = 1;
  Rows* rows_;
};

}  // namespace talus
