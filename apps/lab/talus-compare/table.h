#pragma once
#include <string>
#include <vector>

namespace talus::baselines
{
/** Rows of text under a heading; the first column is left-aligned, the others right-aligned. */
struct Table
{
  std::vector<std::string> heading;
  std::vector<std::vector<std::string>> rows;

  /** The same without columns in which no row has a figure; the first column stays. */
  Table without_empty_columns() const;
  std::string text() const;  //!< for a terminal
  std::string markdown() const;
};

/** A number with so many decimals, "-" for NaN. */
std::string number(double value, int decimals);
/** A share as a percentage with one decimal, "-" for NaN. */
std::string percent(double share);

}  // namespace talus::baselines
