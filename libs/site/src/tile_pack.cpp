#include "tile_pack.h"

#include "channel_values.h"
#include "kept_cell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <tuple>
#include <type_traits>

namespace talus::site
{
namespace
{
constexpr std::size_t kRun = kTileCells;  //!< cells that are packed together
constexpr std::size_t kWord = sizeof(std::uint32_t);
using Words = std::array<std::uint32_t, kRun>;

template <class To, class From>
To bits_as(const From& from)
{
  static_assert(sizeof(To) == sizeof(From));
  To to;
  std::memcpy(&to, &from, sizeof to);
  return to;
}
std::uint32_t bits_of(float v) { return bits_as<std::uint32_t>(v); }

/** The state of a cell and its evidence lie side by side. */
static_assert(offsetof(CellRecord, evidence) == offsetof(CellRecord, state) + 1);
static_assert(CellRecord::kEvidenceBytes == 7);
std::uint64_t octets_at(const std::uint8_t& state)
{
  std::uint64_t octets;
  std::memcpy(&octets, &state, sizeof octets);
  return octets;
}

/// @name Floats in few bits. Where back(of(v)) is not v, a run is stored as it is.
/// @{
struct Height
{
  static std::uint32_t of(float v)
  {
    const float steps = std::abs(v) * kHeightsPerMetre;
    return (steps < kMost ? static_cast<std::uint32_t>(steps) : kMost) << 1 | bits_of(v) >> 31;
  }
  static float back(std::uint32_t code)
  {
    const float v = static_cast<float>(code >> 1) / kHeightsPerMetre;
    return (code & 1) != 0 ? -v : v;
  }
  static constexpr std::uint32_t kMost = 1 << 24;
};
struct Variance
{
  static std::uint32_t of(float v) { return bits_of(v) >> kDroppedBits; }
  static float back(std::uint32_t code) { return bits_as<float>(code << kDroppedBits); }
};
struct Score
{
  static std::uint32_t of(float v)
  {
    return v >= 0 && v <= 1 ? static_cast<std::uint32_t>(v * kScores) : kNone;
  }
  static float back(std::uint32_t code)
  {
    return code == kNone ? NAN : static_cast<float>(code) / kScores;
  }
  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(kScores) + 1;
};
/** Of channels. */
struct Whole
{
  static std::uint32_t of(float v)
  {
    return v >= 0 && v < kMost ? static_cast<std::uint32_t>(v) : 0;
  }
  static float back(std::uint32_t code) { return static_cast<float>(code); }
  static constexpr float kMost = 1 << 16;
};
struct ChannelValue
{
  static std::uint32_t of(float v) { return bits_of(v) >> kDroppedChannelBits; }
  static float back(std::uint32_t code) { return bits_as<float>(code << kDroppedChannelBits); }
};
/// @}

/** Writes the values of runs. */
class Packer
{
 public:
  template <class Code, class At>
  void floats(std::size_t n, const At& at)
  {
    bool is_exact = true;
    for (std::size_t i = 0; i < n; ++i)
    {
      words_[i] = Code::of(at(i));
      is_exact &= bits_of(Code::back(words_[i])) == bits_of(at(i));
    }
    for (std::size_t i = 0; i < n && !is_exact; ++i) words_[i] = bits_of(at(i));
    put(n, is_exact ? kIsCoded : 0);
  }
  template <class At>
  void words(std::size_t n, const At& at)
  {
    for (std::size_t i = 0; i < n; ++i) words_[i] = static_cast<std::uint32_t>(at(i));
    put(n, 0);
  }
  /** Of which many are the same in all: each is the first of eight. */
  template <class At>
  void octets(std::size_t n, const At& at)
  {
    const auto first = octets_at(at(0));
    std::uint64_t differ = 0;
    for (std::size_t i = 1; i < n; ++i) differ |= octets_at(at(i)) ^ first;
    raw(&first, sizeof first);
    raw(&differ, sizeof differ);
    for (int shift = 0; shift < 64; shift += 8)
      if ((differ >> shift & 0xff) != 0)
        words(n, [&](std::size_t i) { return octets_at(at(i)) >> shift & 0xff; });
  }
  void raw(const void* from, std::size_t size)
  {
    const auto* first = static_cast<const std::uint8_t*>(from);
    bytes_.insert(bytes_.end(), first, first + size);
  }
  /** In no more memory than it takes. */
  std::vector<std::uint8_t> bytes() const { return {bytes_.begin(), bytes_.end()}; }

  static constexpr std::uint8_t kIsCoded = 64;

 private:
  /** How far the words are from the least one, in as few bits as that takes. */
  void put(std::size_t n, std::uint8_t flags)
  {
    std::uint32_t least = ~0U, most = 0;
    for (std::size_t i = 0; i < n; ++i)
    {
      least = std::min(least, words_[i]);
      most = std::max(most, words_[i]);
    }
    const std::uint32_t range = n > 0 ? most - least : 0;
    const int width = range == 0 ? 0 : 32 - __builtin_clz(range);
    std::array<std::uint8_t, 1 + kWord + sizeof words_ + kWord> all;
    all[0] = static_cast<std::uint8_t>(width | flags);
    std::memcpy(&all[1], &least, kWord);
    std::uint8_t* to = &all[1 + kWord];
    std::uint64_t open = 0;
    int filled = 0;
    for (std::size_t i = 0; i < n && width > 0; ++i)
    {
      open |= std::uint64_t{words_[i] - least} << filled;
      filled += width;
      if (filled < 32) continue;
      const auto word = static_cast<std::uint32_t>(open);
      std::memcpy(to, &word, kWord);
      to += kWord;
      open >>= 32;
      filled -= 32;
    }
    for (; filled > 0; filled -= 8, open >>= 8) *to++ = static_cast<std::uint8_t>(open);
    raw(all.data(), static_cast<std::size_t>(to - all.data()));
  }

  std::vector<std::uint8_t> bytes_;
  Words words_;
};

/** Reads what a Packer wrote, in the same order. */
class Unpacker
{
 public:
  explicit Unpacker(const std::vector<std::uint8_t>& bytes)
      : from_(bytes.data()), end_(from_ + bytes.size())
  {
  }
  template <class Code, class At>
  void floats(std::size_t n, const At& at)
  {
    const bool is_coded = (get(n) & Packer::kIsCoded) != 0;
    for (std::size_t i = 0; i < n; ++i)
      at(i) = is_coded ? Code::back(words_[i]) : bits_as<float>(words_[i]);
  }
  template <class At>
  void words(std::size_t n, const At& at)
  {
    get(n);
    for (std::size_t i = 0; i < n; ++i)
      at(i) = static_cast<std::remove_reference_t<decltype(at(i))>>(words_[i]);
  }
  template <class At>
  void octets(std::size_t n, const At& at)
  {
    std::uint64_t first = 0, differ = 0;
    raw(&first, sizeof first);
    raw(&differ, sizeof differ);
    std::array<std::uint64_t, kRun> all;
    all.fill(first);
    for (int shift = 0; shift < 64; shift += 8)
    {
      const std::uint64_t octet = std::uint64_t{0xff} << shift;
      if ((differ & octet) == 0) continue;
      get(n);
      for (std::size_t i = 0; i < n; ++i)
        all[i] = (all[i] & ~octet) | std::uint64_t{words_[i]} << shift;
    }
    for (std::size_t i = 0; i < n; ++i) std::memcpy(&at(i), &all[i], sizeof all[i]);
  }
  void raw(void* to, std::size_t size)
  {
    need(size);
    std::memcpy(to, from_, size);
    from_ += size;
  }

 private:
  std::uint8_t get(std::size_t n)
  {
    std::uint8_t head = 0;
    std::uint32_t least = 0;
    raw(&head, 1);
    raw(&least, kWord);
    const int width = head & (Packer::kIsCoded - 1);
    std::size_t left = (n * static_cast<std::size_t>(width) + 7) / 8;
    need(left);
    const std::uint64_t mask = (std::uint64_t{1} << width) - 1;
    std::uint64_t open = 0;
    int filled = 0;
    for (std::size_t i = 0; i < n; ++i)
    {
      if (filled < width)
      {
        const std::size_t size = std::min(left, kWord);
        open |= std::uint64_t{next(size)} << filled;
        left -= size;
        filled += 32;
      }
      words_[i] = least + static_cast<std::uint32_t>(open & mask);
      open >>= width;
      filled -= width;
    }
    from_ += left;
    return head;
  }
  /** A word, or the bytes that are left of the last one. */
  std::uint32_t next(std::size_t size)
  {
    std::uint32_t word = 0;
    if (size == kWord) std::memcpy(&word, from_, kWord);
    for (std::size_t i = 0; size < kWord && i < size; ++i)
      word |= static_cast<std::uint32_t>(from_[i]) << 8 * i;
    from_ += size;
    return word;
  }
  void need(std::size_t size) const
  {
    if (static_cast<std::size_t>(end_ - from_) < size)
      throw std::invalid_argument("a packed tile of the whole map is cut off");
  }

  const std::uint8_t *from_, *end_;
  Words words_;
};

/** How the top of a cell is stored. */
enum Top : std::uint8_t
{
  IsGround,
  None,
  Own
};
Top top_of(const CellRecord& c)
{
  const std::uint32_t height = bits_of(c.elevation_m), variance = bits_of(c.elevation_variance_m2);
  if (height == bits_of(c.ground_m) && variance == bits_of(c.ground_variance_m2)) return IsGround;
  return height == bits_of(NAN) && variance == bits_of(NAN) ? None : Own;
}
void put_top(Top top, CellRecord& c)
{
  if (top == Own) return;
  c.elevation_m = top == None ? NAN : c.ground_m;
  c.elevation_variance_m2 = top == None ? NAN : c.ground_variance_m2;
}
void put_top(Top /*top*/, const CellRecord& /*c*/) {}

/** Those of a run that are not as a cell is at first. Cell: a SiteCell, const where it is packed.
 */
template <class Cell>
struct Run
{
  std::array<Cell*, kRun> cells;
  std::array<Top, kRun> tops;
  std::size_t n = 0;

  /** What is told of them, in its order. */
  template <class P>
  void pass(P& p)
  {
    const auto of = [&](auto member)
    { return [&, member](std::size_t i) -> decltype(auto) { return (cells[i]->cell.*member); }; };
    p.template floats<Height>(n, of(&CellRecord::ground_m));
    p.template floats<Variance>(n, of(&CellRecord::ground_variance_m2));
    p.template floats<Score>(n, of(&CellRecord::traversability));
    p.octets(n, of(&CellRecord::state));
    p.words(n, [&](std::size_t i) -> decltype(auto) { return (cells[i]->seen_s); });
    p.words(n, [&](std::size_t i) -> decltype(auto) { return (tops[i]); });
    std::size_t own = 0;
    for (std::size_t i = 0; i < n; ++i)
    {
      put_top(tops[i], cells[i]->cell);
      if (tops[i] == Own) cells[own++] = cells[i];
    }
    p.template floats<Height>(own, of(&CellRecord::elevation_m));
    p.template floats<Variance>(own, of(&CellRecord::elevation_variance_m2));
  }
};

using Mask = std::array<std::uint64_t, kRun / 64>;  //!< which cells of a run are not as at first
bool is_in(const Mask& mask, std::size_t i) { return (mask[i / 64] >> i % 64 & 1) != 0; }
}  // namespace

std::vector<std::uint8_t> packed(const Tile& tile)
{
  using Bits = std::array<std::uint64_t, sizeof(SiteCell) / sizeof(std::uint64_t)>;
  const auto as_at_first = bits_as<Bits>(SiteCell());
  Packer packer;
  for (std::size_t first = 0; first < tile.cells.size(); first += kRun)
  {
    Run<const SiteCell> run;
    Mask mask{};
    for (std::size_t i = 0; i < kRun; ++i)
    {
      const SiteCell& cell = tile.cells[first + i];
      if (bits_as<Bits>(cell) == as_at_first) continue;
      mask[i / 64] |= std::uint64_t{1} << i % 64;
      run.tops[run.n] = top_of(cell.cell);
      run.cells[run.n++] = &cell;
    }
    packer.raw(mask.data(), sizeof mask);
    if (run.n > 0) run.pass(packer);
  }
  return packer.bytes();
}

namespace
{
constexpr std::size_t kLayers = kChannelSurfaces * kMostChannels;

/** The known values of a layer in a run of cells. */
template <class Record>
struct ValueRun
{
  std::array<Record*, kRun> cells;
  std::size_t n = 0, layer = 0;

  bool is_whole() const
  {
    for (std::size_t i = 0; i < n; ++i)
      if (bits_of(Whole::back(Whole::of(cells[i]->values[layer]))) !=
          bits_of(cells[i]->values[layer]))
        return false;
    return true;
  }
  template <class P>
  void pass(P& p, bool whole)
  {
    const auto at = [&](std::size_t i) -> decltype(auto) { return (cells[i]->values[layer]); };
    if (whole)
      p.template floats<Whole>(n, at);
    else
      p.template floats<ChannelValue>(n, at);
  }
};

/** f(cells of the run, first of which is cells[first], layer) for all runs of a tile. */
template <class F>
void for_each_value_run(const F& f)
{
  for (std::size_t layer = 0; layer < kLayers; ++layer)
    for (std::size_t first = 0; first < std::tuple_size_v<decltype(ChannelTile::cells)>;
         first += kRun)
      f(first, layer);
}

/// @name How the values of a run are stored
/// @{
constexpr std::uint8_t kNoValues = 0, kWholeValues = 1, kOtherValues = 2;
/// @}
}  // namespace

std::vector<std::uint8_t> packed(const ChannelTile& tile)
{
  Packer packer;
  for_each_value_run(
      [&](std::size_t first, std::size_t layer)
      {
        ValueRun<const ChannelRecord> run;
        run.layer = layer;
        Mask mask{};
        for (std::size_t i = 0; i < kRun; ++i)
        {
          const ChannelRecord& cell = tile.cells[first + i];
          if (bits_of(cell.values[layer]) == bits_of(NAN)) continue;
          mask[i / 64] |= std::uint64_t{1} << i % 64;
          run.cells[run.n++] = &cell;
        }
        const std::uint8_t how = run.n == 0       ? kNoValues
                                 : run.is_whole() ? kWholeValues
                                                  : kOtherValues;
        packer.raw(&how, sizeof how);
        if (how == kNoValues) return;
        packer.raw(mask.data(), sizeof mask);
        run.pass(packer, how == kWholeValues);
      });
  return packer.bytes();
}

void unpack(const std::vector<std::uint8_t>& bytes, ChannelTile& tile)
{
  tile = {};
  Unpacker unpacker(bytes);
  for_each_value_run(
      [&](std::size_t first, std::size_t layer)
      {
        std::uint8_t how = kNoValues;
        unpacker.raw(&how, sizeof how);
        if (how == kNoValues) return;
        ValueRun<ChannelRecord> run;
        run.layer = layer;
        Mask mask;
        unpacker.raw(mask.data(), sizeof mask);
        for (std::size_t i = 0; i < kRun; ++i)
          if (is_in(mask, i)) run.cells[run.n++] = &tile.cells[first + i];
        run.pass(unpacker, how == kWholeValues);
      });
}

void unpack(const std::vector<std::uint8_t>& bytes, Tile& tile)
{
  tile = {};
  Unpacker unpacker(bytes);
  for (std::size_t first = 0; first < tile.cells.size(); first += kRun)
  {
    Run<SiteCell> run;
    Mask mask;
    unpacker.raw(mask.data(), sizeof mask);
    for (std::size_t i = 0; i < kRun; ++i)
      if (is_in(mask, i)) run.cells[run.n++] = &tile.cells[first + i];
    if (run.n > 0) run.pass(unpacker);
  }
}

}  // namespace talus::site
