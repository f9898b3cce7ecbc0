#pragma once
#include "cpu_clones.h"
#include "kernels/cell.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

// Bodies of the CPU executors' loops that are more than a loop.

namespace talus
{
/** f(x, y, i) for x in [begin, end) of a row, i from `first` on. */
template <class F>
TALUS_CLONES void over_row(F f, int begin, int end, int y, int first)
{
  TALUS_INDEPENDENT
  for (int x = begin; x < end; x++) f(x, y, first + (x - begin));
}

/** f(x, y, i) of a row of the window, i where the cell is stored: two stretches of a torus. */
template <class F>
void over_stored_row(const F& f, int cells, const kernels::FrameContext& frame, int y)
{
  const int row = kernels::storage_index(frame, cells, 0, y) - frame.storage_x;
  const int turn = cells - frame.storage_x;
  over_row(f, 0, turn, y, row + frame.storage_x);
  over_row(f, turn, cells, y, row);
}

/** Structures of 32-bit fields in a row, an array each field, so that loops over them vectorise. */
template <class T>
class Lanes
{
  static constexpr std::size_t kFields = std::tuple_size<decltype(T::fields())>::value;
  using Value = typename T::Value;

 public:
  static constexpr int words(int lanes) { return static_cast<int>(kFields) * lanes; }
  Lanes(Value* memory, int lanes) : data_(memory), lanes_(lanes) {}

  T load(int lane) const
  {
    T t;
    each([&](auto field, int k) { t.*field = data_[k * lanes_ + lane]; });
    return t;
  }
  void store(int lane, const T& t) const
  {
    each([&](auto field, int k) { data_[k * lanes_ + lane] = t.*field; });
  }

 private:
  template <class G>
  static void each(const G& g)
  {
    std::apply([&](auto... field) { int k = 0; (g(field, k++), ...); }, T::fields());
  }
  Value* data_;
  int lanes_;
};

/** Sums over the square neighbourhoods of the cells in a strip of columns, row by row: F::Row of
 * each row once, F::Window of those that slide along. */
template <class F>
class SlidingRows
{
  using Row = typename F::Row;
  using Window = typename F::Window;
  using Value = typename Row::Value;
  static constexpr int kLanes = 128;

 public:
  SlidingRows(int nx, int ny, int radius, const F& f) : nx_(nx), ny_(ny), radius_(radius), f_(f)
  {
    while (mask_ < 2 * radius) mask_ = 2 * mask_ + 1;
    auto& words = memory();
    const auto size = static_cast<std::size_t>(window_at() + Lanes<Window>::words(kLanes));
    if (words.size() < size) words.resize(size);
    words_ = words.data();
  }

  /** f of the cells of rows [begin, end). */
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
      for (; next <= std::min(y + radius_, ny_ - 1); next++) sum_row(f_, at(next), x0, x1, next, radius_);
      window(y, x0, x1);
    }
  }

  TALUS_CLONES static void sum_row(F f, Lanes<Row> rows, int x0, int x1, int y, int radius)
  {
    const Row none;
    TALUS_INDEPENDENT
    for (int x = x0; x < x1; x++) rows.store(x - x0, none);
    for (int d = -radius; d <= radius; d++)
    {
      TALUS_INDEPENDENT
      for (int x = x0; x < x1; x++)
      {
        Row row = rows.load(x - x0);
        f.add(row, x, y, d);
        rows.store(x - x0, row);
      }
    }
  }

  void window(int y, int x0, int x1) const
  {
    const Lanes<Window> sums(words_ + window_at(), kLanes);
    clear(sums, x1 - x0);
    for (int row = std::max(y - radius_, 0); row <= std::min(y + radius_, ny_ - 1); row++)
      add_row(f_, sums, at(row), x1 - x0, row - y);
    finish(f_, sums, x0, x1, y);
    for (int x = x0; x < x1; x++) f_.finish(x, y, [&] { return sums.load(x - x0); });
  }
  TALUS_CLONES static void clear(Lanes<Window> sums, int lanes)
  {
    const Window none;
    for (int l = 0; l < lanes; l++) sums.store(l, none);
  }
  TALUS_CLONES static void add_row(F f, Lanes<Window> sums, Lanes<Row> row, int lanes, int d)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < lanes; l++)
    {
      Window sum = sums.load(l);
      f.add(sum, row.load(l), d);
      sums.store(l, sum);
    }
  }
  TALUS_CLONES static void finish(F f, Lanes<Window> sums, int x0, int x1, int y)
  {
    TALUS_INDEPENDENT
    for (int x = x0; x < x1; x++) f(x, y, sums.load(x - x0));
  }

  int window_at() const { return (mask_ + 1) * Lanes<Row>::words(kLanes); }
  Lanes<Row> at(int y) const
  {
    return {words_ + (y & mask_) * Lanes<Row>::words(kLanes), kLanes};
  }
  /** Of this thread, kept from frame to frame. */
  static std::vector<Value>& memory()
  {
    static thread_local std::vector<Value> words;
    return words;
  }

  int nx_, ny_, radius_, mask_ = 1;
  const F& f_;
  Value* words_;
};

/** One word of 32 answers. */
template <class F>
struct PackWord
{
  int lines, bits;
  const F& f;
  std::uint32_t* words;

  void operator()(int line, int word) const
  {
    std::uint32_t packed = 0;
    const auto bit = f(line);
    const int count = std::min(32, bits - 32 * word);
    for (int b = 0; b < count; b++) packed |= static_cast<std::uint32_t>(bit(32 * word + b)) << b;
    words[word * lines + line] = packed;
  }
};

}  // namespace talus
