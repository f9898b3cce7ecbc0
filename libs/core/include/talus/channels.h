#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace talus
{
struct Frame;

constexpr std::size_t kMaxChannels = 4;  //!< max channels of a map
constexpr int kChannelClasses = 16;  //!< classes of a channel that is put to the vote: 0 to 15

/** How the values of a channel become one value of a cell. */
enum class ChannelRule : int
{
  Mean = 0,  //!< of the points seen lately: it counts at most 64 of those before a frame
  Latest,  //!< the mean of the points of the last frame that saw the surface
  Max,  //!< the greatest value since the cell entered the window
  Vote  //!< the class of most points seen lately; values are classes, whole numbers from 0 to 15
};

/** Names of the rules in texts. */
constexpr std::array<const char*, 4> kChannelRuleNames{"mean", "latest", "max", "vote"};

/** A value that users bring to each point, such as its intensity or its class. */
struct Channel
{
  std::string name;  //!< small letters, digits and `_`, a letter first
  ChannelRule rule = ChannelRule::Mean;  //!< how its values become one of a cell
};

/** The same name and rule. */
inline bool operator==(const Channel& a, const Channel& b)
{
  return a.name == b.name && a.rule == b.rule;
}

/** What a class of a channel that is put to the vote costs. */
struct ChannelCost
{
  std::string channel;  //!< its name
  int class_of = 0;  //!< from 0 to 15
  double score = 0;  //!< [0, 1] max score of a cell of this class; 0: impassable
};

/** The surfaces of a cell that have values of their own: the ground, and what stands on it. */
constexpr std::size_t kChannelSurfaces = 2;

/** The values of the channels of a cell, in the order of channel_layer_names(); NaN: unknown. */
struct ChannelRecord
{
  /** Of the ground, then of what stands there; channel after channel. */
  float values[kChannelSurfaces * kMaxChannels] = {NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
};

/** The channels that a text such as "intensity:mean,label:vote" names; "none" or nothing: none.
 * Throws std::invalid_argument that names what is wrong with it, as validate_channels() does. */
std::vector<Channel> channels_from(const std::string& text);
/** The text that channels_from() reads back. */
std::string channels_text(const std::vector<Channel>& channels);

/** Throws std::invalid_argument for more than kMaxChannels channels, two of one name, and a name
 * that is none or that a layer of maps has. */
void validate_channels(const std::vector<Channel>& channels);

/** Names of the layers of channels: NAME of the ground, then NAME_standing of what stands there. */
std::vector<std::string> channel_layer_names(const std::vector<Channel>& channels);

/** The index of a name in channel_layer_names(). Throws std::invalid_argument that says that
 * `what`, "map" say, has no such layer. */
std::size_t channel_layer(
    const std::vector<Channel>& channels, const std::string& name, const std::string& what);

/** The costs that a text such as "label:3=0,7=0.5" gives: a name holds for what follows it; "none"
 * or nothing: none. Throws std::invalid_argument that names what is wrong with it. */
std::vector<ChannelCost> channel_costs_from(const std::string& text);
/** The text that channel_costs_from() reads back. */
std::string channel_costs_text(const std::vector<ChannelCost>& costs);
/** Throws std::invalid_argument for a channel that is none of `channels` or not put to the vote,
 * and for what is no class or no score, or a class that is given twice. */
void validate_channel_costs(
    const std::vector<ChannelCost>& costs, const std::vector<Channel>& channels);

/** Puts those of `more` that `all` does not have behind it; validate_channels() of the result.
 * Throws std::invalid_argument where both have one of a name, with different rules. */
void add_channels(std::vector<Channel>& all, const std::vector<Channel>& more);

/** By layer of `of`, see channel_layer_names(): the same layer of `in`, which has all of them. */
std::vector<std::size_t> channel_indices(
    const std::vector<Channel>& of, const std::vector<Channel>& in);

/** Whether a channel of this rule may have the value: NaN, a class for a vote. */
bool is_channel_value(ChannelRule rule, float value);

/** Throws std::invalid_argument where a frame has values of a channel that the map does not have,
 * or a class that is no whole number from 0 to 15; it names the channel and the value. */
void require_channels(const Frame& frame, const std::vector<Channel>& channels);

}  // namespace talus
