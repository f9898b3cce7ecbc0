#include "topics.h"

#include <algorithm>
#include <stdexcept>

namespace talus::app
{
namespace
{
bool is_tf(const live::Offer& offer) { return offer.type == "tf2_msgs/msg/TFMessage"; }
/** "/robot1" of "/robot1/tf". */
std::string space_of(const std::string& topic) { return topic.substr(0, topic.rfind('/')); }
bool is_in_space(const std::string& topic, const std::string& space)
{
  return topic.compare(0, space.size() + 1, space + "/") == 0;
}
}  // namespace

Topics::Topics(
    live::Participant& network, const std::vector<std::string>& wanted, const std::string& path)
    : network_(network), wanted_(wanted), path_(path)
{
}

bool Topics::is_wanted(const live::Offer& offer) const
{
  if (offer.topic == path_) return import::is_path(offer.type);
  if (!import::ScanStream::reads(offer.topic, offer.type) || is_of_other_robot(offer)) return false;
  if (!is_settled()) return false;
  if (!import::ScanStream::is_cloud(offer.type) || wanted_.empty()) return true;
  return std::find(wanted_.begin(), wanted_.end(), offer.topic) != wanted_.end();
}

/** Which robot is mapped is known, or that none has TF of its own. */
bool Topics::is_settled() const
{
  constexpr int kSettle_looks = 5;  // within which all are known
  return robot_ || looks_ > kSettle_looks;
}

/** Several robots tell the same frames, each on topics of its own with TF: one of them is heard, as
 * a node of ROS hears one. */
void Topics::choose_robot()
{
  if (!offers_.empty()) ++looks_;
  for (const auto& offer : offers_)
    if (is_tf(offer)) robots_.insert(space_of(offer.topic));
  if (robot_ || robots_.empty()) return;
  for (const auto& robot : robots_)
    for (const auto& topic : wanted_)
      if (!robot.empty() && is_in_space(topic, robot)) robot_ = robot;
  const bool is_usual = wanted_.empty() && robots_.begin()->empty();
  if (!robot_ && (is_settled() || is_usual)) robot_ = *robots_.begin();
}

bool Topics::is_of_other_robot(const live::Offer& offer) const
{
  if (is_tf(offer)) return space_of(offer.topic) != robot_;
  return std::any_of(
      robots_.begin(), robots_.end(),
      [&](const auto& robot)
      { return !robot.empty() && robot != robot_ && is_in_space(offer.topic, robot); });
}

std::vector<std::string> Topics::look(const import::ScanStream& stream)
{
  constexpr int kDepth = 20, kDepthOfTf = 500;
  std::vector<std::string> news;
  const auto say = [&](const std::string& text)
  {
    if (told_.insert(text).second) news.push_back(text);
  };
  offers_ = network_.offers();
  choose_robot();
  for (const auto& offer : offers_)
  {
    const bool is_cloud = import::ScanStream::is_cloud(offer.type);
    if (!is_wanted(offer))
    {
      if (!is_settled()) continue;
      if (offer.topic == path_) say(path_ + " is left out: it is " + offer.type + ", no Path");
      if (is_of_other_robot(offer) && (is_cloud || is_tf(offer)))
        say(offer.topic + " is left out: the robot of " + *robot_ +
            "/tf is mapped; --topic with a cloud of another one takes that one");
      else if (is_cloud)
        say(offer.topic + " is left out: --topic does not name it");
      continue;
    }
    const auto heard = heard_.find(offer.topic);
    const bool is_heard =
        heard != heard_.end() && (!heard->second.is_reliable || offer.quality.is_reliable ||
                                  offer.type != heard->second.type);
    if (is_heard || !stream.wants(offer.topic)) continue;
    auto quality = offer.quality;
    const bool is_path = offer.topic == path_;
    quality.depth = is_cloud ? kDepth : is_path ? 1 : kDepthOfTf;
    say("hears " + offer.topic + " (" + offer.type + ", " +
        (quality.is_reliable ? "reliable" : "best effort") + ")");
    heard_[offer.topic] = {
        offer.topic,
        offer.type,
        std::make_unique<live::Subscription>(network_, offer.topic, offer.type, quality),
        quality.is_reliable,
        is_cloud,
        is_path};
  }
  for (auto heard = heard_.begin(); heard != heard_.end();)
    heard = stream.wants(heard->first) ? std::next(heard) : heard_.erase(heard);
  return news;
}

void Topics::take_into(import::ScanStream& stream, Heard& heard, double now_s)
{
  while (const auto message = heard.messages->take())
  {
    max_bytes_ = std::max(max_bytes_, message->size());
    stream.add(heard.topic, heard.type, *message, now_s);
  }
}

void Topics::take_into(import::ScanStream& stream, double now_s)
{
  for (const bool is_cloud : {false, true})
    for (auto& [topic, heard] : heard_)
      if (heard.is_cloud == is_cloud && !heard.is_path) take_into(stream, heard, now_s);
}

std::optional<import::StreamPath> Topics::take_path()
{
  std::optional<import::StreamPath> path;
  const auto heard = heard_.find(path_);
  if (heard == heard_.end()) return path;
  try
  {
    while (const auto message = heard->second.messages->take()) path = import::path_from(*message);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error("a message of " + path_ + " " + e.what());
  }
  return path;
}

std::size_t Topics::lost() const
{
  std::size_t count = 0;
  for (const auto& [topic, heard] : heard_) count += heard.messages->lost();
  return count;
}

std::string Topics::why_nothing() const
{
  constexpr std::size_t kMax = 30;
  if (offers_.empty())
    return "nobody publishes a topic here: is ROS_DOMAIN_ID (or --domain) that of the robot, and "
           "is "
           "this its network? CYCLONEDDS_URI names an interface; a firewall has to let UDP through";
  for (const auto& [topic, heard] : heard_)
    if (heard.is_cloud && heard.messages->publishers() > 0) return "";
  std::string list;
  for (std::size_t i = 0; i < std::min(offers_.size(), kMax); ++i)
    list += (i == 0 ? " " : ", ") + offers_[i].topic.substr(0, 100) + " " +
            offers_[i].type.substr(0, 100);
  if (offers_.size() > kMax) list += ", and " + std::to_string(offers_.size() - kMax) + " more";
  return "no topic with clouds (sensor_msgs/msg/PointCloud2) is published" +
         std::string(wanted_.empty() ? "" : " that --topic names") + ". There are:" + list;
}

}  // namespace talus::app
