#pragma once
#include "cpu/executor.h"
#include "kernels/group.h"
#include "kernels/map.h"

#include <algorithm>
#include <array>
#include <vector>

namespace talus::test
{
struct DeviceOnHostAtomics : kernels::SerialAtomics
{
  static std::uint64_t reserve(std::uint64_t* where, std::uint64_t value)
  {
    const std::uint64_t before = *where;
    *where = before + value;
    return before;
  }
};

/** What runs on a device, on the host: the stages in the device's order with the device's rules,
 * by plain loops on plain memory, so that every machine executes them. A warp is a group of one.
 * What a device does at once is done from the last to the first here, since no order may matter. */
class DeviceOnHost : public CpuMemory
{
 public:
  using Atomics = DeviceOnHostAtomics;
  static constexpr bool kIsDevice = true;

  std::string name() const { return "cpu (the device's schedule)"; }

  /** Of two outputs one is written by kernels, the other is copied. */
  OutputMemory map_output(float* host, std::size_t)
  {
    copies_ = !copies_;
    return {host, !copies_};
  }

  // ---- one frame, of the slot in use ----
  void use(int slot)
  {
    CpuMemory::use(slot);
    slot_ = static_cast<std::size_t>(slot);
  }
  int loop_size(int, std::size_t capacity) const { return static_cast<int>(capacity); }
  /** A device has a copy of the points. */
  kernels::PointsIn stage(
      const Frame& frame, const kernels::FrameContext& context, std::size_t capacity)
  {
    CpuMemory::stage(frame, context, capacity);
    const PointArrays to = point_arrays(capacity);
    float* const arrays[] = {to.x_m, to.y_m, to.z_m, to.time_s};
    const float* const from[] = {frame.x_m, frame.y_m, frame.z_m, frame.time_s};
    for (std::size_t a = 0; a < 4; a++)
      if (from[a] && from[a] != arrays[a]) std::copy_n(from[a], frame.size, arrays[a]);
    return {to.x_m, to.y_m, to.z_m, to.time_s};
  }
  /** A channel that a frame does not have is there, and says nothing. */
  ChannelArrays stage_channels(const Frame& frame, std::size_t channels, std::size_t capacity)
  {
    auto& memory = channels_[slot_];
    memory.assign(channels * capacity, kernels::kNan);
    ChannelArrays arrays{};
    for (std::size_t c = 0; c < channels; c++)
    {
      arrays[c] = memory.data() + c * capacity;
      if (frame.channels[c])
        std::copy_n(frame.channels[c], frame.size, memory.data() + c * capacity);
    }
    return arrays;
  }
  template <class Body>
  void start_frame(const Body& body, bool)
  {
    start_clock();
    body();
  }
  template <class Body, class Then>
  void finish_frame(const Body&, const Then& then)
  {
    then();
  }
  kernels::FrameCounts* reported() { return &reported_[slot_]; }

  // ---- loops ----
  template <class Rule>
  void for_each(const kernels::Map& m, int n)
  {
    for (int i = n; i-- > 0;) run(Rule{m}, i, 0);
  }
  template <class F, class T>
  void for_each_to_host(int n, const F& f, T* to)
  {
    for (int i = n; i-- > 0;) to[i] = f(i);
  }
  template <class F, class T>
  void for_each_from_host(int n, const F& f, const T* from)
  {
    for (int i = n; i-- > 0;) f(i, from[i]);
  }
  template <class First, class Then, class Cells>
  void for_each_beside(const kernels::Map& m, int firsts, int n, int nx, int ny)
  {
    for_each_cell<Cells>(m, {0, 0, nx, ny});
    for_each<Then>(m, n - firsts);
    for_each<First>(m, firsts);
  }
  template <class F>
  void for_each_and_group(const kernels::Map& m, int n, int)
  {
    const F f{m};
    int cell = -1;
    for (int i = n; i-- > 0;)
      if ((cell = f.lone_cell(i)) >= 0) f.update(cell, kernels::SerialGroup{});
    for (int slot = 0; (cell = f.crowded_cell(slot)) >= 0; slot++)
      f.update(cell, kernels::SerialGroup{});
  }
  template <class Rule>
  void for_each_cell(const kernels::Map& m, const WindowRect& r)
  {
    over(r, [&m](int x, int y) { kernels::apply<Rule>(m, x, y); });
  }
  /** Both forms in which a device searches a cell's lines. */
  template <class F>
  void for_each_cell_by_lines(const kernels::Map& m, int first, int end, bool)
  {
    const F f{m};
    const auto fill = [&f](int x, int y) { (x + y) % 2 ? f(x, y) : by_lines(f, x, y); };
    over({0, first, m.k.cells, end - first}, fill);
  }
  /** Each direction in as many stretches as on a device. */
  template <class F, class First, class Then, class H>
  void for_each_direction_beside(const kernels::Map& m, int directions, int firsts, int n)
  {
    H{m}(kernels::SerialGroup{});
    for_each<Then>(m, n - firsts);
    for_each<First>(m, firsts);
    for (int d = directions; d-- > 0;) settle(F{m}, d, F{m}.rings());
  }
  template <class F>
  void pack_bits(const kernels::Map& m, int lines, int bits, std::uint32_t* words)
  {
    std::fill_n(words, (bits + 31) / 32 * lines, 0u);
    for (int line = lines; line-- > 0;)
      for (int bit = 0; bit < bits; bit++)
        if (F{m}(line, bit)) words[bit / 32 * lines + line] |= 1u << bit % 32;
  }
  template <class F>
  void mark_cells(const kernels::Map& m, std::uint32_t* marks)
  {
    const F f{m};
    const int side = m.k.cells;
    const auto inspect = [&](int x, int y)
    {
      if (f.begin(x, y)) f.inspect(x, y, kernels::SerialGroup{});
    };
    over({0, 0, side, side}, inspect);
    std::fill_n(marks, (side + 31) / 32 * 2 * side, 0u);
    const auto mark = [&](int x, int y)
    {
      if (!f(x, y)) return;
      marks[x / 32 * 2 * side + y] |= 1u << x % 32;
      marks[y / 32 * 2 * side + side + x] |= 1u << y % 32;
    };
    over({0, 0, side, side}, mark);
  }
  template <class F>
  void for_each_window(const kernels::Map& m, int nx, int ny, int radius)
  {
    const F f{m};
    windows(f, nx, ny, radius, 0, ny, f);
  }
  template <class F, class G>
  void for_each_judged_cell_of_rows(
      const kernels::Map& m, int nx, int ny, int first, int end, int radius, bool)
  {
    const F f{m};
    const G g{m};
    const int from = std::max(first - 1, 0), to = std::min(end + 1, ny), pitch = nx + 2;
    std::vector<float> judged(static_cast<std::size_t>(pitch * (to - from + 2)), kernels::kNan);
    std::vector<std::uint8_t> passability(judged.size(), 0);
    const auto at = [&](int x, int y) { return (y - from + 1) * pitch + x + 1; };
    windows(
        f, nx, ny, radius, from, to,
        [&](int x, int y, const auto& sum)
        {
          const kernels::Judgement j = f.judge(x, y, sum, y >= first && y < end);
          judged[static_cast<std::size_t>(at(x, y))] = j.score;
          passability[static_cast<std::size_t>(at(x, y))] =
              static_cast<std::uint8_t>(j.passability);
        });
    for (int y = end; y-- > first;)
      for (int x = nx; x-- > 0;)
        g.complete(
            x, y, {passability.data() + at(x, y), pitch},
            judged[static_cast<std::size_t>(at(x, y))]);
  }
  template <class T>
  void fill(Buffer<T>& buffer, T value)
  {
    std::fill(buffer.begin(), buffer.end(), value);
  }
  void join() {}
  template <class Body>
  void aside(const Body& body)
  {
    body();
  }
  /** Bands do not need each other. */
  template <class Body>
  void in_bands(int rows, int, int, const Body& body)
  {
    body(rows / 3, rows, true);
    body(0, rows / 3, false);
  }

 private:
  static constexpr int kStretches = 32;

  /** f(x, y) for the cells of a rectangle. */
  template <class F>
  static void over(const WindowRect& r, const F& f)
  {
    for (int y = r.first_y + r.height; y-- > r.first_y;)
      for (int x = r.first_x + r.width; x-- > r.first_x;) f(x, y);
  }

  /** f(i, early), where f reads something early; else f(i). */
  template <class F>
  static auto run(const F& f, int i, int) -> decltype(f.early(i), void())
  {
    f(i, f.early(i));
  }
  template <class F>
  static void run(const F& f, int i, long)
  {
    f(i);
  }

  template <class F>
  static void by_lines(const F& f, int x, int y)
  {
    std::array<typename F::Side, 2 * F::kLines> sides;
    std::array<typename F::Line, F::kLines> lines;
    for (int part = 0; part < 2 * F::kLines; part++)
      sides[static_cast<std::size_t>(part)] = f.side(part / 2, part % 2 == 1, x, y);
    for (std::size_t l = 0; l < lines.size(); l++)
      lines[l] = f.line(sides[2 * l], sides[2 * l + 1]);
    f(x, y, sides[0], sides[1], f.behind(x, y), lines.data(), 1);
  }

  template <class F>
  static void settle(const F& f, int direction, int rings)
  {
    const int length = (rings + kStretches - 1) / kStretches;
    const auto begin = [&](int s) { return s * length; };
    const auto end = [&](int s) { return std::min((s + 1) * length, rings); };
    std::array<typename F::Before, kStretches + 1> before;  // sums of the stretches before
    std::array<typename F::Behind, kStretches + 1> behind;
    for (int s = 0; s < kStretches; s++)
    {
      typename F::Before own;
      f.collect(direction, begin(s), end(s), own);
      before[static_cast<std::size_t>(s) + 1] = own;
      before[static_cast<std::size_t>(s) + 1].add(before[static_cast<std::size_t>(s)]);
    }
    for (int s = kStretches; s-- > 0;)
    {
      typename F::Behind own;
      f.bury(direction, begin(s), end(s), before[static_cast<std::size_t>(s)], own);
      behind[static_cast<std::size_t>(s)] = behind[static_cast<std::size_t>(s) + 1];
      behind[static_cast<std::size_t>(s)].add(own);
    }
    for (int s = 0; s < kStretches; s++)
      f.sweep(direction, begin(s), end(s), behind[static_cast<std::size_t>(s) + 1]);
  }

  /** use(x, y, sum) of square neighbourhoods, for the rows [first, end) of ny: along rows, then
   * across them. */
  template <class F, class Use>
  static void windows(const F& f, int nx, int ny, int radius, int first, int end, const Use& use)
  {
    const int low = std::max(first - radius, 0), high = std::min(end + radius, ny);
    std::vector<typename F::Row> rows(
        static_cast<std::size_t>(high - low) * static_cast<std::size_t>(nx));
    const auto row = [&](int x, int y) ->
        typename F::Row& { return rows[static_cast<std::size_t>((y - low) * nx + x)]; };
    for (int y = low; y < high; y++)
      for (int x = 0; x < nx; x++)
        for (int d = -radius; d <= radius; d++) f.add(row(x, y), x, y, d);
    for (int y = end; y-- > first;)
      for (int x = nx; x-- > 0;)
      {
        typename F::Window sum;
        for (int d = -radius; d <= radius; d++)
          if (y + d >= low && y + d < high) f.add(sum, row(x, y + d), d);
        use(x, y, sum);
      }
  }

  bool copies_ = false;
  std::size_t slot_ = 0;
  std::array<kernels::FrameCounts, kSlots> reported_{};
  std::array<std::vector<float>, kSlots> channels_;
};

}  // namespace talus::test
