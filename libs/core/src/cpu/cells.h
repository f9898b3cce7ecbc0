#pragma once
#include "cpu/side_by_side.h"
#include "kernels/3_update.h"
#include "kernels/group.h"

#include <algorithm>

// Stage 3 on the CPU: thirty-two cells with about as many points, side by side in vector code.

namespace talus::cells
{
/** Cells side by side, and their max number of points; larger cells are updated one by one. */
constexpr int kLanes = 32, kMax = 32;

template <class T>
using Lanes = SideBySide<T, kLanes>;

class alignas(64) Batch : public kernels::CellUpdate<Batch, Lanes>
{
 public:
  /** The last of the `lanes` cells has the most points. */
  [[gnu::flatten]] void update(const kernels::Map& m, const std::int32_t* of, int lanes)
  {
    gather(m, of, lanes);
    run_all(*this, m.k);
    const kernels::UpdateCell update{m};
    for (int l = 0; l < lanes; l++) update.put(of[l], cells.load(l), ends.load(l));
  }

  template <class F>
  void each_lane(const F& f)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++) f(l);
  }
  template <class Sum, class Question>
  void add(Lanes<Sum>& sums, const Lanes<Question>& asked, const kernels::Config& k)
  {
    for (int p = 0; p < most_; p++)
    {
      TALUS_INDEPENDENT
      for (int l = 0; l < kLanes; l++)
      {
        Sum sum = sums.load(l);
        sum.add(points_[p].load(l), p < size_[l], asked.load(l), k);
        sums.store(l, sum);
      }
    }
  }

 private:
  void gather(const kernels::Map& m, const std::int32_t* of, int lanes)
  {
    for (int l = 0; l < kLanes; l++)
    {
      const int i = of[std::min(l, lanes - 1)];
      const kernels::HeightPoint* const from = m.sorted + m.cell_begin[i];
      cells.store(l, m.cell.load(i));
      size_[l] = static_cast<int>(m.kept_count[i]);
      for (int p = 0; p < size_[l]; p++) points_[p].store(l, from[p]);
    }
    most_ = size_[kLanes - 1];
  }
  TALUS_CLONES static void run_all(Batch& g, const kernels::Config k) { g.run(k); }

  int most_ = 0;
  int size_[kLanes];
  Lanes<kernels::HeightPoint> points_[kMax];
};

/** The cells that received points. Cells of one part of the window come together, for a thread's
 * cache; in each part by the number of points, in batches. The largest are batches of their own. */
class Order
{
 public:
  Order(const kernels::Map& m, int parts) : m_(m), parts_(std::min(parts, kMaxParts)) {}

  /** Finds the cells of n points and reserves their ranges. */
  void find(int n)
  {
    const std::int32_t* const found = m_.crowded;
    cells_ = m_.crowded + n;
    const int cells = list(n);
    int start[kMaxParts * kKinds + 1] = {};  // of the cells of one kind
    for (int c = 0; c < cells; c++) start[kind_of(found[c]) + 1]++;
    for (int kind = 0; kind < parts_ * kKinds; kind++) start[kind + 1] += start[kind];
    cut(start);
    std::uint32_t begin = 0;
    for (int c = 0; c < cells; c++)
    {
      cells_[start[kind_of(found[c])]++] = found[c];
      m_.cell_begin[found[c]] = begin;
      begin += m_.kept_count[found[c]];
    }
  }

  int batches() const { return cuts_[parts_].batch; }
  int cells() const { return cuts_[parts_].cell; }
  void update(int begin, int end) const
  {
    Batch side_by_side{};
    const Cut* part = cuts_;
    for (int batch = begin; batch < end; batch++)
    {
      while (batch >= part[1].batch) part++;
      const int full = batches_of(part->lone - part->cell), k = batch - part->batch;
      const bool is_lone = k >= full;
      const int first = is_lone ? part->lone + k - full : part->cell + k * kLanes;
      const int lanes = is_lone ? 1 : std::min(kLanes, part->lone - first);
      if (is_lone)
        kernels::UpdateCell{m_}.update(cells_[first], kernels::SerialGroup{});
      else
        side_by_side.update(m_, cells_ + first, lanes);
    }
  }
  /** Clears the point counts of the cells [begin, end) for the next frame. */
  void forget_points(int begin, int end) const
  {
    for (int c = begin; c < end; c++) m_.kept_count[cells_[c]] = 0;
  }

 private:
  static constexpr int kMaxParts = 16, kKinds = kMax + 2;
  /** Where the cells of a part, its largest ones, and its batches begin. */
  struct Cut
  {
    int cell = 0, lone = 0, batch = 0;
  };

  /** Lists the cells in the order of their first points. */
  int list(int n) const
  {
    const std::int32_t* const point_cell = m_.point_cell;
    const std::uint32_t* const rank = m_.point_rank;
    std::int32_t* const found = m_.crowded;
    int cells = 0;
    for (int i = 0; i < n; i++)
    {
      const std::int32_t cell = point_cell[i];
      found[cells] = cell;
      cells += (rank[i] | static_cast<std::uint32_t>(cell >> 31)) == 0;  // rank 0, in a cell
    }
    return cells;
  }
  /** A kind is a part and a number of points. */
  int kind_of(int cell) const
  {
    const int points = std::min(static_cast<int>(m_.kept_count[cell]), kMax + 1);
    if (parts_ == 1) return points;
    const int n = m_.k.cells, index = cell - m_.frame->storage_y * n;
    const float share =
        static_cast<float>(index + (index < 0 ? n * n : 0)) / static_cast<float>(n * n);
    const int part = std::min(static_cast<int>(share * static_cast<float>(parts_)), parts_ - 1);
    return part * kKinds + points;
  }
  static int batches_of(int cells) { return (cells + kLanes - 1) / kLanes; }
  void cut(const int* start)
  {
    for (int part = 0; part < parts_; part++)
    {
      const int first = part * kKinds, lone = start[first + kMax + 1], end = start[first + kKinds];
      cuts_[part].cell = start[first], cuts_[part].lone = lone;
      cuts_[part + 1].cell = end;
      cuts_[part + 1].batch = cuts_[part].batch + batches_of(lone - start[first]) + end - lone;
    }
  }

  const kernels::Map& m_;
  int parts_;
  std::int32_t* cells_ = nullptr;
  Cut cuts_[kMaxParts + 1];
};

}  // namespace talus::cells
