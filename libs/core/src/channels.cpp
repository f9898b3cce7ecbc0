#include <talus/channels.h>
#include <talus/frame.h>
#include <talus/layers.h>
#include <talus/number_text.h>
#include <talus/text.h>
#include "kernels/9_channels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus
{
namespace
{
static_assert(kMaxChannels == kernels::kMaxChannels);
static_assert(kChannelSurfaces == kernels::kPointSurfaces);
static_assert(kChannelClasses == kernels::kClasses);
static_assert(static_cast<int>(ChannelRule::Vote) == kernels::kVote);

constexpr const char *kNone = "none", *kStanding = "_standing";

[[noreturn]] void fail(const std::string& what, const std::string& parameter = "channels")
{
  throw std::invalid_argument(parameter + ": " + what);
}
[[noreturn]] void fail_cost(const std::string& what) { fail(what, "channel_cost"); }

std::vector<Channel>::const_iterator find_channel(
    const std::vector<Channel>& channels, const std::string& name)
{
  return std::find_if(
      channels.begin(), channels.end(), [&](const Channel& c) { return c.name == name; });
}

std::string rule_names()
{
  std::string text;
  for (const char* name : kChannelRuleNames) text += (text.empty() ? "" : ", ") + std::string(name);
  return text;
}

Channel channel_from(const std::string& text)
{
  const auto colon = text.find(':');
  if (colon == std::string::npos)
    fail("'" + text + "' has no rule: must be NAME:RULE, the rule one of " + rule_names());
  const std::string rule = text.substr(colon + 1);
  const auto found = std::find(kChannelRuleNames.begin(), kChannelRuleNames.end(), rule);
  if (found == kChannelRuleNames.end())
    fail("'" + text + "': no rule is called '" + rule + "'; there are " + rule_names());
  return {text.substr(0, colon), static_cast<ChannelRule>(found - kChannelRuleNames.begin())};
}

ChannelCost cost_from(const std::string& piece, std::string& channel)
{
  const std::string form = "must be NAME:CLASS=SCORE, for example label:3=0,7=0.5";
  const auto colon = piece.find(':'), equals = piece.find('=');
  if (equals == std::string::npos) fail_cost("'" + piece + "' " + form);
  if (colon < equals) channel = piece.substr(0, colon);
  if (channel.empty()) fail_cost("'" + piece + "' names no channel: " + form);
  const auto begin = colon < equals ? colon + 1 : 0;
  const auto class_of = number_from(piece.substr(begin, equals - begin));
  const auto score = number_from(piece.substr(equals + 1));
  const bool is_class = class_of && *class_of >= 0 && *class_of < kChannelClasses &&
                        *class_of == std::floor(*class_of);
  if (!is_class)
    fail_cost(
        "'" + piece + "': a class is a whole number from 0 to " +
        std::to_string(kChannelClasses - 1));
  if (!score || !(*score >= 0 && *score <= 1))
    fail_cost("'" + piece + "': a score is a number from 0 (impassable) to 1 (as the map says)");
  return {channel, static_cast<int>(*class_of), *score};
}

bool is_name(const std::string& name)
{
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto fits = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && is_letter(name[0]) && std::all_of(name.begin(), name.end(), fits);
}

/** By another band of files of maps. */
bool is_taken(const std::string& name) { return find_layer(name) || ends_with(name, kStanding); }

/** Whether a value is NaN or a class; without branches, so that many are asked at once. */
bool is_class_or_none(float v)
{
  constexpr float kMiddle = 0.5F * static_cast<float>(kChannelClasses - 1), kNoFractions = 8388608;
  return (v != v) | ((std::abs(v - kMiddle) <= kMiddle) & ((v + kNoFractions) - kNoFractions == v));
}
}  // namespace

std::vector<Channel> channels_from(const std::string& text)
{
  std::vector<Channel> channels;
  if (text.empty() || text == kNone) return channels;
  for (const std::string& piece : pieces_of(text, ",")) channels.push_back(channel_from(piece));
  validate_channels(channels);
  return channels;
}

std::string channels_text(const std::vector<Channel>& channels)
{
  std::string text;
  for (const Channel& c : channels)
    text += (text.empty() ? "" : ",") + c.name + ":" +
            kChannelRuleNames[static_cast<std::size_t>(c.rule)];
  return text.empty() ? kNone : text;
}

void validate_channels(const std::vector<Channel>& channels)
{
  if (channels.size() > kMaxChannels)
    fail(
        std::to_string(channels.size()) + " of them; a map has " + std::to_string(kMaxChannels) +
        " at most");
  for (auto c = channels.begin(); c != channels.end(); ++c)
  {
    if (!is_name(c->name))
      fail("'" + c->name + "' is no name: small letters, digits and _, a letter first");
    if (is_taken(c->name)) fail("'" + c->name + "' is the name of a layer: choose another");
    if (find_channel(channels, c->name) != c) fail("two of them are called '" + c->name + "'");
    const int rule = static_cast<int>(c->rule);
    if (rule < 0 || rule >= static_cast<int>(kChannelRuleNames.size()))
      fail("'" + c->name + "' has no rule");
  }
}

std::vector<ChannelCost> channel_costs_from(const std::string& text)
{
  std::vector<ChannelCost> costs;
  if (text.empty() || text == kNone) return costs;
  std::string channel;
  for (const std::string& piece : pieces_of(text, ","))
    costs.push_back(
        cost_from(piece.substr(std::min(piece.find_first_not_of(' '), piece.size())), channel));
  return costs;
}

std::string channel_costs_text(const std::vector<ChannelCost>& costs)
{
  std::string text;
  for (const ChannelCost& c : costs)
    text += (text.empty() ? "" : ",") + c.channel + ":" + std::to_string(c.class_of) + "=" +
            exact_number_text(c.score);
  return text.empty() ? kNone : text;
}

void validate_channel_costs(
    const std::vector<ChannelCost>& costs, const std::vector<Channel>& channels)
{
  for (auto c = costs.begin(); c != costs.end(); ++c)
  {
    const std::string cost = "'" + channel_costs_text({*c}) + "'";
    const auto named = find_channel(channels, c->channel);
    if (named == channels.end())
      fail_cost(
          cost + ": the map has no channel '" + c->channel +
          "', its channels are: " + channels_text(channels));
    if (named->rule != ChannelRule::Vote)
      fail_cost(cost + ": '" + channels_text({*named}) + "' has no classes, only a vote has them");
    if (c->class_of < 0 || c->class_of >= kChannelClasses || !(c->score >= 0 && c->score <= 1))
      fail_cost(cost + ": a class is from 0 to 15, a score from 0 to 1");
    if (std::any_of(
            costs.begin(), c,
            [&](const ChannelCost& b)
            { return b.channel == c->channel && b.class_of == c->class_of; }))
      fail_cost("class " + std::to_string(c->class_of) + " of '" + c->channel + "' is given twice");
  }
}

std::vector<std::string> channel_layer_names(const std::vector<Channel>& channels)
{
  std::vector<std::string> names;
  for (const Channel& c : channels)
  {
    names.push_back(c.name);
    names.push_back(c.name + kStanding);
  }
  return names;
}

std::size_t channel_layer(
    const std::vector<Channel>& channels, const std::string& name, const std::string& what)
{
  const std::vector<std::string> names = channel_layer_names(channels);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw std::invalid_argument(
        "this " + what + " has no channel layer '" + name +
        "'; its channels are: " + channels_text(channels));
  return static_cast<std::size_t>(found - names.begin());
}

void add_channels(std::vector<Channel>& all, const std::vector<Channel>& more)
{
  for (const Channel& c : more)
  {
    const auto same = find_channel(all, c.name);
    if (same == all.end())
      all.push_back(c);
    else if (same->rule != c.rule)
      fail("'" + channels_text({*same}) + "' has another rule in '" + channels_text({c}) + "'");
  }
  validate_channels(all);
}

std::vector<std::size_t> channel_indices(
    const std::vector<Channel>& of, const std::vector<Channel>& in)
{
  std::vector<std::size_t> indices;
  for (const std::string& name : channel_layer_names(of))
    indices.push_back(channel_layer(in, name, "list"));
  return indices;
}

bool is_channel_value(ChannelRule rule, float value)
{
  if (rule == ChannelRule::Vote) return is_class_or_none(value);
  return std::isnan(value) || std::abs(value) <= kernels::kMaxChannelValue;
}

void require_channels(const Frame& frame, const std::vector<Channel>& channels)
{
  for (std::size_t c = 0; c < kMaxChannels; c++)
  {
    const float* const values = frame.channels[c];
    if (!values) continue;
    if (c >= channels.size())
      fail(
          "a frame has values of channel " + std::to_string(c + 1) + ", and the map has " +
          std::to_string(channels.size()) + ": name it in Parameters::channels");
    if (channels[c].rule != ChannelRule::Vote) continue;
    const float* const end = values + frame.size;
    int others = 0;
    for (const float* v = values; v != end; v++) others += !is_class_or_none(*v);
    if (others == 0) continue;
    const float* const bad = std::find_if_not(values, end, is_class_or_none);
    fail(
        "'" + channels[c].name + "' has the value " + number_text(*bad) +
        ", which is no class: a vote needs whole numbers from 0 to " +
        std::to_string(kChannelClasses - 1));
  }
}

}  // namespace talus
