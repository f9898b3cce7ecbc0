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
  /** Whether what stood in a cell was not there in the last frames that hit it. */
  bool has_left(double x_m, double y_m) const;

 private:
  struct Hits
  {
    float lowest_m = std::numeric_limits<float>::infinity();
    float highest_m = -std::numeric_limits<float>::infinity();
    bool stood = false;  //!< something, in any frame
    int bare_after = 0;  //!< frames with ground alone since then
  };
  using Key = std::pair<std::int64_t, std::int64_t>;
  Key key(double x_m, double y_m) const;
  const Hits* find(const Key& cell) const;
  void add(const std::vector<MapPoint>& points);

  double resolution_m_;
  std::map<Key, Hits> hits_;
};

/** Of the cells of the site of the whole drive that are labelled kMoves: blocked. Throws
 * std::runtime_error as TileStore. */
Share swept_blocked(const Sequence& sequence, const LabelMap& labels, const Parameters& parameters);

}  // namespace talus::baselines
