#pragma once
#include "cpu/clones.h"
#include "cpu/side_by_side.h"
#include "kernels/3_update.h"
#include "kernels/group.h"

#include <algorithm>

// Stage 3 on the CPU. Most cells have few points: thirty-two cells with about as many points are
// updated side by side, in vector code without branches.

namespace talus::cells
{
/** Cells side by side, and their most points; larger cells are updated one by one. */
constexpr int kLanes = 32, kMost = 32;

class alignas(64) Batch
{
  using Cell = kernels::Cell;
  using Config = kernels::Config;

 public:
  /** The last of the `lanes` cells has the most points. */
  [[gnu::flatten]] void update(const kernels::Map& m, const std::int32_t* cells, int lanes)
  {
    gather(m, cells, lanes);
    run(*this, m.k);
    const kernels::UpdateCell update{m};
    for (int l = 0; l < lanes; l++) update.put(cells[l], cells_.load(l), ends_.load(l));
  }

 private:
  void gather(const kernels::Map& m, const std::int32_t* cells, int lanes)
  {
    for (int l = 0; l < kLanes; l++)
    {
      const int i = cells[std::min(l, lanes - 1)];
      const kernels::HeightPoint* const from = m.sorted + m.cell_begin[i];
      cells_.store(l, m.cell.load(i));
      size_[l] = static_cast<int>(m.kept_count[i]);
      for (int p = 0; p < size_[l]; p++) points_[p].store(l, from[p]);
    }
    most_ = size_[kLanes - 1];
  }

  /** kernels::update_cell() for all of them. */
  TALUS_CLONES static void run(Batch& g, const Config k)
  {
    g.find_ends(k);
    g.update_ground(k);
    g.update_elevation(k);
    g.find_overhangs(k);
  }

  void find_ends(const Config& k)
  {
    up_to_.fill({});
    reduce(ends_, up_to_, k);
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
      hangs_[l] = kernels::all_hang(cells_.load(l), ends_.load(l), k);
  }

  void update_ground(const Config& k)
  {
    fuse(
        k, [&](int l) { return kernels::plan_ground(cells_.load(l), ends_.load(l).lowest(), k); },
        kernels::put_ground);
  }

  void update_elevation(const Config& k)
  {
    scan_clearance(k);
    const auto plan = [&](int l)
    {
      const kernels::HeightPoint high = highest_.load(l).highest();
      return kernels::plan_elevation(cells_.load(l), high, scan_.load(l).top_m, k);
    };
    fuse(k, plan, kernels::put_elevation);
    const auto put = [&](Cell& c, int l)
    { kernels::put_high_hit(c, scan_.load(l).top_m, ends_.load(l).highest(), k); };
    each_cell(put);
  }

  /** Fuses the points of each plan(l), and puts the result into the cell. */
  template <class Plan, class Put>
  void fuse(const Config& k, const Plan& plan, const Put& put)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++) plan_.store(l, plan(l));
    reduce(fusion_, plan_, k);
    each_cell([&](Cell& c, int l) { put(c, hangs_[l] != 0, plan_.load(l), fusion_.load(l), k); });
  }

  /** Finds the highest point that stands. */
  void scan_clearance(const Config& k)
  {
    int any = 0;
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      scan_.store(l, {kernels::sure_top_m(cells_.load(l))});
      any |= scan_.load(l).top_m < ends_.load(l).highest().height_m;
    }
    while (any)
    {
      last_ = scan_;
      add(scan_, last_, k);
      any = 0;
      TALUS_INDEPENDENT
      for (int l = 0; l < kLanes; l++)
        any |= scan_.load(l).goes_on(last_.load(l), ends_.load(l).highest().height_m);
    }
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      const float top_m = scan_.load(l).top_m;
      up_to_.store(l, {top_m});
      any |= top_m < ends_.load(l).highest().height_m;
    }
    highest_ = ends_;
    if (any) reduce(highest_, up_to_, k);
  }

  void find_overhangs(const Config& k)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++) up_to_.store(l, kernels::overhangs_up_to(cells_.load(l), k));
    reduce(overhang_, up_to_, k);
    each_cell([&](Cell& c, int l) { kernels::put_overhang(c, overhang_.load(l), k); });
  }

  /** Changes each cell by f(cell, l). */
  template <class F>
  void each_cell(const F& f)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      Cell c = cells_.load(l);
      f(c, l);
      cells_.store(l, c);
    }
  }

  /** Reduces the points of each cell, from an empty sum or a given one. */
  template <class Sum, class Question>
  void reduce(
      SideBySide<Sum, kLanes>& sums, const SideBySide<Question, kLanes>& asked, const Config& k)
  {
    sums.fill({});
    add(sums, asked, k);
  }
  template <class Sum, class Question>
  void add(
      SideBySide<Sum, kLanes>& sums, const SideBySide<Question, kLanes>& asked, const Config& k)
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

  int most_ = 0;
  int size_[kLanes], hangs_[kLanes];
  SideBySide<Cell, kLanes> cells_;
  SideBySide<kernels::HeightPoint, kLanes> points_[kMost];
  SideBySide<kernels::UpTo, kLanes> up_to_;
  SideBySide<kernels::Extremes, kLanes> ends_, highest_;
  SideBySide<kernels::FusionPlan, kLanes> plan_;
  SideBySide<kernels::Fusion, kLanes> fusion_;
  SideBySide<kernels::ClearanceScan, kLanes> scan_, last_;
  SideBySide<kernels::Overhang, kLanes> overhang_;
};

/** The cells that received points. Cells of one part of the window come together, so that a thread
 * has them in its cache; in each part by the number of points, in batches. The largest cells are
 * batches of their own. */
class Order
{
 public:
  Order(const kernels::Map& m, int parts) : m_(m), parts_(std::min(parts, kMostParts)) {}

  /** Finds the cells of n points and reserves their ranges. */
  void find(int n)
  {
    const std::int32_t* const found = m_.crowded;
    cells_ = m_.crowded + n;
    const int cells = list(n);
    int start[kMostParts * kKinds + 1] = {};  // of the cells of one kind
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
  static constexpr int kMostParts = 16, kKinds = kMost + 2;
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
    const int points = std::min(static_cast<int>(m_.kept_count[cell]), kMost + 1);
    if (parts_ == 1) return points;
    const int n = m_.k.cells, place = cell - m_.frame->storage_y * n;
    const float share =
        static_cast<float>(place + (place < 0 ? n * n : 0)) / static_cast<float>(n * n);
    const int part = std::min(static_cast<int>(share * static_cast<float>(parts_)), parts_ - 1);
    return part * kKinds + points;
  }
  static int batches_of(int cells) { return (cells + kLanes - 1) / kLanes; }
  void cut(const int* start)
  {
    for (int part = 0; part < parts_; part++)
    {
      const int first = part * kKinds, lone = start[first + kMost + 1], end = start[first + kKinds];
      cuts_[part].cell = start[first], cuts_[part].lone = lone;
      cuts_[part + 1].cell = end;
      cuts_[part + 1].batch = cuts_[part].batch + batches_of(lone - start[first]) + end - lone;
    }
  }

  const kernels::Map& m_;
  int parts_;
  std::int32_t* cells_ = nullptr;
  Cut cuts_[kMostParts + 1];
};

}  // namespace talus::cells
