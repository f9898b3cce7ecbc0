#pragma once
#include <cstdint>
#include <vector>

namespace talus::baselines
{
/** Goes from the cells of `todo` to those of their four neighbours that `goes(from, to)` allows,
 * and on from there; marks in `reached` what it comes to. Index = iy * cells_x + ix. */
template <class Goes>
void spread(
    std::vector<int> todo, std::vector<std::uint8_t>& reached, int cells_x, const Goes& goes)
{
  const int size = static_cast<int>(reached.size());
  while (!todo.empty())
  {
    const int i = todo.back(), x = i % cells_x;
    todo.pop_back();
    for (int next : {x > 0 ? i - 1 : -1, x + 1 < cells_x ? i + 1 : -1, i - cells_x, i + cells_x})
    {
      if (next < 0 || next >= size || reached[static_cast<std::size_t>(next)]) continue;
      if (!goes(static_cast<std::size_t>(i), static_cast<std::size_t>(next))) continue;
      reached[static_cast<std::size_t>(next)] = 1;
      todo.push_back(next);
    }
  }
}

}  // namespace talus::baselines
