#pragma once
#include <gdal_priv.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <string>

// What all files of maps say of their bands.
namespace talus::io
{
/** Where a band comes in a file: those that all maps have lie first, in one order. Bands of other
 * names come last. */
std::size_t index_of_band(const std::string& name);

/** "m", "m2", "s", or empty. */
const char* unit_of_band(const std::string& name);

/** Smallest, largest, mean and deviation of the values that are known. */
class BandStatistics
{
 public:
  /** NaN counts as unknown. */
  void add(float value)
  {
    if (std::isnan(value)) return;
    const double v = value, off = v - mean_;
    count_ += 1;
    mean_ += off / count_;
    squares_ += off * (v - mean_);
    min_ = std::min(min_, v);
    max_ = std::max(max_, v);
  }
  /** What GDAL's programs read; `cells`: of the band, known or not. Nothing where none is known. */
  std::map<std::string, std::string> items(double cells) const;

 private:
  double count_ = 0, mean_ = 0, squares_ = 0;
  double min_ = std::numeric_limits<double>::infinity(), max_ = -min_;
};

/** The items of the metadata of a band: its statistics, and what its numbers mean where they are
 * those of classes. */
std::map<std::string, std::string> band_items(
    const std::string& name, const BandStatistics& statistics, double cells);

}  // namespace talus::io
