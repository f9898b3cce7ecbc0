#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

// Bodies of the CPU executors' loops that are more than a loop.

namespace talus
{
/** The rows that the neighbourhoods of one row of cells need, as they slide along. */
template <class F>
class SlidingRows
{
 public:
  SlidingRows(int nx, int ny, int radius, const F& f)
      : nx_(nx), ny_(ny), radius_(radius), f_(f), rows_(memory())
  {
    while (mask_ < 2 * radius) mask_ = 2 * mask_ + 1;
    rows_.resize(static_cast<std::size_t>(mask_ + 1) * static_cast<std::size_t>(nx));
  }

  /** f of the cells of rows [begin, end). */
  void run(int begin, int end)
  {
    int next = std::max(begin - radius_, 0);
    for (int y = begin; y < end; y++)
    {
      for (; next <= std::min(y + radius_, ny_ - 1); next++)
        for (int x = 0; x < nx_; x++) *at(x, next) = f_.row(x, next);
      for (int x = 0; x < nx_; x++)
        f_(x, y, [&](int row) -> const Row& { return *at(x, row); });
    }
  }

 private:
  using Row = typename F::Row;
  Row* at(int x, int y) { return rows_.data() + static_cast<std::size_t>(y & mask_) * width() + x; }
  std::size_t width() const { return static_cast<std::size_t>(nx_); }
  /** Of this thread, kept from frame to frame. */
  static std::vector<Row>& memory()
  {
    static thread_local std::vector<Row> rows;
    return rows;
  }

  int nx_, ny_, radius_, mask_ = 1;
  const F& f_;
  std::vector<Row>& rows_;
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
