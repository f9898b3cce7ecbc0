#pragma once
#include <talus/baselines/real_log.h>

#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace talus::baselines
{
/** What all frames of a log hit, cell by cell. */
class CellHits
{
 public:
  /** Two passes: what is up is told by the lowest of all. */
  CellHits(const Sequence& sequence, const Parameters& p);

  /** -infinity: nothing was hit. */
  float highest_m(double x_m, double y_m) const;
  /** Whether what stood in a cell has left. */
  bool has_left(std::int64_t x, std::int64_t y) const;
  /** Whether something moved through a cell: it stood there for a moment, the cell was bare before
   * or after in as many frames, and so were most cells near it in which something stood. Else it is
   * the edge of what stands. */
  bool was_swept(std::int64_t x, std::int64_t y) const;

 private:
  struct Hits
  {
    float lowest_m = std::numeric_limits<float>::infinity();
    float highest_m = -std::numeric_limits<float>::infinity();
    int up_frames = 0;  //!< in which something stood there
    int bare_before = 0, bare_after = 0;  //!< frames with ground alone, before the first and since
                                          //!< the last of them
    bool stood_for_a_moment() const;
    bool stood_on_bare_ground() const;
  };
  using Key = std::pair<std::int64_t, std::int64_t>;
  Key key(double x_m, double y_m) const;
  const Hits* find(const Key& cell) const;
  void add(const std::vector<MapPoint>& points);

  double resolution_m_;
  std::int64_t near_cells_;
  std::map<Key, Hits> hits_;
};

/** Of the cells of the site of the whole drive that movers swept: blocked. Where labels say what
 * moves, these are the cells. Throws std::runtime_error as TileStore. */
Share swept_blocked(
    const Sequence& sequence, const CellHits& hits, const LabelMap* labels,
    const Parameters& parameters);

}  // namespace talus::baselines
