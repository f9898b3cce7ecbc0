#pragma once
#include "kernels/math.h"
#include "kernels/rule_constants.h"

namespace talus::kernels
{
/** The surface of a cell that a point belongs to. */
enum PointSurface : std::int32_t
{
  kNoSurface = -1,
  kOfGround = 0,
  kOfObject,
  kPointSurfaces
};

constexpr int kMaxChannels = 4, kClasses = 16;

/** The values of talus::ChannelRule. */
enum ChannelRule : std::int32_t
{
  kMean = 0,
  kLatest,
  kMax,
  kVote
};

/** What a channel knows of one surface of a cell. */
struct ChannelValue
{
  float value = kNan;  //!< NaN: unknown
  std::uint32_t weight = 0;  //!< points behind it, up to kMeanOfPoints or kVotesOfPoints
};

/** The points of the frame on one surface of a cell; empty between frames. */
struct ChannelSum
{
  std::uint64_t units = 0;  //!< their values [1 / kChannelUnits], below zero as two's complement
  std::uint32_t points = 0;
  std::int32_t highest = kLowestOrdered;  //!< of their values, as an ordered integer

  static constexpr std::int32_t kLowestOrdered = -0x7fffffff - 1;
};

/** The points of the frame by their class, and how many count of those before. */
struct ChannelVotes
{
  std::uint32_t of_frame[kClasses];
  std::uint8_t kept[kClasses];
};

/** One channel of a map and its part of a frame. The surfaces of a cell are neighbours. */
struct Channel
{
  std::int32_t rule;  //!< a ChannelRule
  const float* of_points;  //!< null: the frame has no values
  ChannelSum* sums;
  ChannelValue* values;
  ChannelVotes* votes;  //!< null: no kVote

  static TALUS_HD int at(int storage_i, int surface)
  {
    return storage_i * kPointSurfaces + surface;
  }

  /** Takes the value of a point. Returns whether it is the first on its surface in this frame. */
  template <class Atomics>
  TALUS_HD bool add(int i, float value) const
  {
    if (!(value >= -kMaxChannelValue && value <= kMaxChannelValue)) return false;  // also NaN
    if (rule == kVote)
      Atomics::add(votes[i].of_frame + (static_cast<int>(value) & (kClasses - 1)), 1u);
    else if (rule == kMax)
      Atomics::max(&sums[i].highest, ordered_from_float(value));
    else
      Atomics::add(&sums[i].units, units_of(value));
    return Atomics::add(&sums[i].points, 1u) == 0;
  }

  /** Fuses what a frame added with what was known. */
  TALUS_HD void settle(int i) const
  {
    const ChannelSum of_frame = sums[i];
    sums[i] = ChannelSum{};
    ChannelValue& known = values[i];
    if (rule == kVote)
      count_votes(known, votes[i], of_frame.points);
    else if (rule == kMax)
    {
      const float highest = float_from_ordered(of_frame.highest);
      known.value = known.value >= highest ? known.value : highest;  // NaN is not
    }
    else
      known = mean_with(known, of_frame, rule == kMean ? kMeanOfPoints : 0);
  }

  /** Takes a value that was known before, as that of one point, where none is known. */
  TALUS_HD void restore(int i, float value) const
  {
    if (!(value >= -kMaxChannelValue && value <= kMaxChannelValue)) return;  // also NaN
    if (values[i].value == values[i].value) return;
    values[i] = {value, 1};
    if (rule == kVote) votes[i].kept[static_cast<int>(value) & (kClasses - 1)] = 1;
  }

  TALUS_HD void forget(int i) const
  {
    values[i] = ChannelValue{};
    if (votes)
      for (std::uint8_t& kept : votes[i].kept) kept = 0;
  }

 private:
  static TALUS_HD std::uint64_t units_of(float value)
  {
    const double units = static_cast<double>(value) * kChannelUnits;
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(units));
  }
  static TALUS_HD ChannelValue
  mean_with(const ChannelValue& known, const ChannelSum& of_frame, std::uint32_t max_weight)
  {
    const double sum = static_cast<double>(static_cast<std::int64_t>(of_frame.units));
    const double points = static_cast<double>(of_frame.points);
    const double mean = sum / (points * kChannelUnits);
    const double before = known.weight ? static_cast<double>(known.value) : mean;
    const double share = points / (static_cast<double>(known.weight) + points);
    ChannelValue now;
    now.value = static_cast<float>(before + share * (mean - before));
    // Of points, too, there may be more than an integer of 32 bits holds together with the weight.
    now.weight =
        of_frame.points >= max_weight - known.weight ? max_weight : known.weight + of_frame.points;
    return now;
  }
  /** Adds the votes of the frame; the first class with the max becomes the value. */
  static TALUS_HD void count_votes(ChannelValue& known, ChannelVotes& votes, std::uint32_t of_frame)
  {
    const int leads = known.weight ? static_cast<int>(known.value) : 0;
    if (votes.of_frame[leads] == of_frame && known.weight &&
        of_frame <= kVotesOfPoints - known.weight)
    {  // as below, since nothing else has changed
      votes.of_frame[leads] = 0;
      votes.kept[leads] = static_cast<std::uint8_t>(votes.kept[leads] + of_frame);
      known.weight += of_frame;
      return;
    }
    std::uint32_t all = 0;
    int winner = 0;
    for (int c = 0; c < kClasses; c++)
    {
      votes.of_frame[c] += votes.kept[c];
      all += votes.of_frame[c];
      if (votes.of_frame[c] > votes.of_frame[winner]) winner = c;
    }
    int halvings = 0;
    while (all >> halvings > kVotesOfPoints) halvings++;
    known = {static_cast<float>(winner), 0};
    for (int c = 0; c < kClasses; c++)
    {
      votes.kept[c] = static_cast<std::uint8_t>(votes.of_frame[c] >> halvings);
      known.weight += votes.kept[c];
      votes.of_frame[c] = 0;
    }
  }
};

struct Channels
{
  int size;
  Channel each[kMaxChannels];
};

}  // namespace talus::kernels
