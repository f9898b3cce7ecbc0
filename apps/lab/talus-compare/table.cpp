#include "report.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

namespace talus::baselines
{
namespace
{
std::vector<std::size_t> widths(const Table& t)
{
  std::vector<std::size_t> w;
  for (const auto& cell : t.heading) w.push_back(cell.size());
  for (const auto& row : t.rows)
    for (std::size_t c = 0; c < row.size(); ++c) w[c] = std::max(w[c], row[c].size());
  return w;
}

std::string padded(const std::string& s, std::size_t width, bool left)
{
  const std::string pad(width > s.size() ? width - s.size() : 0, ' ');
  return left ? s + pad : pad + s;
}

}  // namespace

Table Table::without_empty_columns() const
{
  Table out;
  out.rows.resize(rows.size());
  for (std::size_t c = 0; c < heading.size(); ++c)
  {
    const auto is_empty = [&](const auto& row) { return row[c] == "-"; };
    if (c > 0 && std::all_of(rows.begin(), rows.end(), is_empty)) continue;
    out.heading.push_back(heading[c]);
    for (std::size_t r = 0; r < rows.size(); ++r) out.rows[r].push_back(rows[r][c]);
  }
  return out;
}

std::string Table::text() const
{
  const auto w = widths(*this);
  std::string out;
  const auto line = [&](const std::vector<std::string>& row)
  {
    for (std::size_t c = 0; c < row.size(); ++c) out += "  " + padded(row[c], w[c], c == 0);
    out += "\n";
  };
  line(heading);
  for (const auto& row : rows) line(row);
  return out;
}

std::string Table::markdown() const
{
  std::string out = "|";
  for (const auto& cell : heading) out += " " + cell + " |";
  out += "\n|";
  for (std::size_t c = 0; c < heading.size(); ++c) out += c ? "---:|" : "---|";
  for (const auto& row : rows)
  {
    out += "\n|";
    for (const auto& cell : row) out += " " + cell + " |";
  }
  return out + "\n";
}

std::string number(double value, int decimals)
{
  return std::isnan(value) ? "-" : fixed_text(value, decimals);
}

std::string percent(double share) { return number(100 * share, 1); }

}  // namespace talus::baselines
