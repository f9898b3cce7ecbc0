#pragma once
#include "cpu_clones.h"
#include "cpu_lanes.h"
#include "kernels/4_update.h"

#include <algorithm>

// Stage 4 on the CPU. Most cells have few points: thirty-two cells of about as many are updated
// side by side, in vector code without branches that nobody could predict.

namespace talus::cells
{
/** Points of such a cell; cells of more are updated one by one. */
constexpr int kMost = 32;

/** Cells that are updated side by side, and their points. */
class alignas(64) Group
{
  using Cell = kernels::Cell;
  using Config = kernels::Config;

 public:
  /** Of `lanes` cells, the last of which has the most points. */
  void update(const kernels::UpdateCell& update, const std::int32_t* cells, int lanes)
  {
    gather(update, cells, lanes);
    run(*this, *update.config);
    for (int l = 0; l < lanes; l++)
    {
      update.store.store(cells[l], cells_.load(l));
      update.top_hit_m[cells[l]] = ends_.load(l).highest().height_m;
    }
  }

 private:
  void gather(const kernels::UpdateCell& update, const std::int32_t* cells, int lanes)
  {
    for (int l = 0; l < kLanes; l++)
    {
      const int i = cells[std::min(l, lanes - 1)];
      const kernels::HeightPoint* const from = update.sorting.sorted + update.sorting.cell_begin[i];
      cells_.store(l, update.store.load(i));
      size_[l] = static_cast<int>(update.sorting.kept_count[i]);
      for (int p = 0; p < size_[l]; p++) points_[p].store(l, from[p]);
    }
    most_ = size_[kLanes - 1];
  }

  /** kernels::update_cell() of all of them. */
  TALUS_CLONES static void run(Group& g, const Config k)
  {
    g.find_ends(k);
    g.update_ground(k);
    g.update_elevation(k);
    g.find_overhangs(k);
  }

  void find_ends(const Config& k)
  {
    up_to_.fill({});
    look(ends_, up_to_, k);
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      Cell c = cells_.load(l);
      hangs_[l] = kernels::all_hang(c, ends_.load(l), k);
      cells_.store(l, c);
    }
  }

  void update_ground(const Config& k)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
      plan_.store(l, kernels::plan_ground(cells_.load(l), ends_.load(l).lowest(), k));
    look(fusion_, plan_, k);
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      Cell c = cells_.load(l);
      kernels::put_ground(c, hangs_[l] != 0, plan_.load(l), fusion_.load(l), k);
      cells_.store(l, c);
    }
  }

  void update_elevation(const Config& k)
  {
    climb(k);
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
      plan_.store(
          l, kernels::plan_elevation(
                 cells_.load(l), highest_.load(l).highest(), climb_.load(l).top_m, k));
    look(fusion_, plan_, k);
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      Cell c = cells_.load(l);
      kernels::put_elevation(c, hangs_[l] != 0, plan_.load(l), fusion_.load(l), k);
      cells_.store(l, c);
    }
  }

  /** To the highest point that stands. */
  void climb(const Config& k)
  {
    int any = 0;
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      const float start_m = kernels::start_of_climb(cells_.load(l)).top_m;
      climb_.store(l, {kernels::select(hangs_[l] != 0, kernels::kInfinity, start_m)});
      any |= climb_.load(l).top_m < ends_.load(l).highest().height_m;
    }
    while (any)
    {
      last_ = climb_;
      add(climb_, last_, k);
      any = 0;
      TALUS_INDEPENDENT
      for (int l = 0; l < kLanes; l++)
        any |= climb_.load(l).goes_on(last_.load(l), ends_.load(l).highest().height_m);
    }
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      const float top_m = climb_.load(l).top_m;
      up_to_.store(l, {top_m});
      any |= top_m < ends_.load(l).highest().height_m;
    }
    highest_ = ends_;
    if (any) look(highest_, up_to_, k);
  }

  void find_overhangs(const Config& k)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++) up_to_.store(l, {cells_.load(l).ground_m + k.clearance_m});
    look(overhang_, up_to_, k);
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      Cell c = cells_.load(l);
      kernels::put_overhang(c, overhang_.load(l));
      cells_.store(l, c);
    }
  }

  /** What the points of each cell add to nothing, or to a sum. */
  template <class Sum, class Question>
  void look(SideBySide<Sum>& sums, const SideBySide<Question>& asked, const Config& k)
  {
    sums.fill({});
    add(sums, asked, k);
  }
  template <class Sum, class Question>
  void add(SideBySide<Sum>& sums, const SideBySide<Question>& asked, const Config& k)
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
  SideBySide<Cell> cells_;
  SideBySide<kernels::HeightPoint> points_[kMost];
  SideBySide<kernels::UpTo> up_to_;
  SideBySide<kernels::Extremes> ends_, highest_;
  SideBySide<kernels::FusionPlan> plan_;
  SideBySide<kernels::Fusion> fusion_;
  SideBySide<kernels::Climb> climb_, last_;
  SideBySide<kernels::Overhang> overhang_;
};

/** The cells that received points in order of how many, cut into groups; those of very many are
 * groups of their own. */
class Order
{
 public:
  /** Of n points; reserves the stretches of the cells. */
  Order(int n, const kernels::UpdateCell& update)
      : update_(update), cells_(update.sorting.crowded + n)
  {
    const std::int32_t* const found = update.sorting.crowded;
    const int cells = find(n);
    int start[kMost + 3] = {};  // of the cells of so many points
    for (int c = 0; c < cells; c++) start[points_of(found[c]) + 1]++;
    for (int points = 0; points < kMost + 2; points++) start[points + 1] += start[points];
    grouped_ = start[kMost + 1];
    lone_ = cells - grouped_;
    std::uint32_t begin = 0;
    for (int c = 0; c < cells; c++)
    {
      cells_[start[points_of(found[c])]++] = found[c];
      update.sorting.cell_begin[found[c]] = begin;
      begin += update.sorting.kept_count[found[c]];
    }
  }

  int groups() const { return (grouped_ + kLanes - 1) / kLanes + lone_; }
  /** Of the groups [begin, end); their counts of points become zero, for the next frame. */
  void update(int begin, int end) const
  {
    Group side_by_side{};
    const int full = groups() - lone_;
    for (int group = begin; group < end; group++)
    {
      const bool is_lone = group >= full;
      const std::int32_t* const cells =
          cells_ + (is_lone ? grouped_ + group - full : group * kLanes);
      const int lanes = is_lone ? 1 : std::min(kLanes, grouped_ - group * kLanes);
      if (is_lone)
        update_.update(*cells, kernels::LoneTeam{});
      else
        side_by_side.update(update_, cells, lanes);
      for (int l = 0; l < lanes; l++) update_.sorting.kept_count[cells[l]] = 0;
    }
  }

 private:
  /** Lists the cells as their first points come. */
  int find(int n) const
  {
    const kernels::PointsOut& points = update_.points;
    int cells = 0;
    for (int i = 0; i < n; i++)
    {
      update_.sorting.crowded[cells] = points.cell[i];
      cells += (points.cell[i] >= 0) & (points.rank[i] == 0);
    }
    return cells;
  }
  int points_of(int cell) const
  {
    return std::min(static_cast<int>(update_.sorting.kept_count[cell]), kMost + 1);
  }

  const kernels::UpdateCell& update_;
  std::int32_t* cells_;
  int grouped_ = 0, lone_ = 0;
};

}  // namespace talus::cells
