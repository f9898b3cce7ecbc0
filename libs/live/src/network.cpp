#include <talus/live/network.h>

#include <talus/input_file.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <set>
#include <stdexcept>

#include <cdr_writer.h>
#include "raw_type.h"

namespace talus::live
{
namespace
{
constexpr const char* kNodes = "ros_discovery_info";
constexpr const char* kNodesType = "rmw_dds_common/msg/ParticipantEntitiesInfo";

[[noreturn]] void fail(const std::string& what, dds_return_t code)
{
  throw std::runtime_error(what + ": " + dds_strretcode(-code));
}

dds_entity_t checked(dds_entity_t entity, const std::string& what)
{
  if (entity < 0) fail(what, entity);
  return entity;
}

/** Deletes what it holds. */
class Entity
{
 public:
  explicit Entity(dds_entity_t entity = 0) : entity_(entity) {}
  ~Entity() { dds_delete(entity_); }
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  operator dds_entity_t() const { return entity_; }

 private:
  dds_entity_t entity_;
};

struct DeleteQos
{
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, DeleteQos>;

Qos qos_of(const Quality& quality)
{
  Qos qos(dds_create_qos());
  // Who writes waits for nobody for long.
  dds_qset_reliability(
      qos.get(), quality.is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
      DDS_MSECS(100));
  dds_qset_durability(
      qos.get(), quality.is_kept ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  if (quality.is_kept)
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, quality.depth, -1, -1, -1);
  const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &representation);
  return qos;
}

/** "rt/points" for "/points"; what has no slash is not of ROS's topics. */
std::string name_in_dds(const std::string& topic) { return topic[0] == '/' ? "rt" + topic : topic; }

/** "sensor_msgs::msg::dds_::PointCloud2_" for "sensor_msgs/msg/PointCloud2". */
std::string type_in_dds(const std::string& type)
{
  const auto first = type.find('/'), last = type.rfind('/');
  if (first == std::string::npos || first == last) return type;
  return type.substr(0, first) + "::" + type.substr(first + 1, last - first - 1) +
         "::dds_::" + type.substr(last + 1) + "_";
}

std::string type_in_ros(const std::string& type)
{
  const std::string middle = "::dds_::";
  const auto first = type.find("::"), at = type.find(middle);
  if (at == std::string::npos || first >= at || type.back() != '_') return type;
  const auto name = type.substr(at + middle.size());
  return type.substr(0, first) + "/" + type.substr(first + 2, at - first - 2) + "/" +
         name.substr(0, name.size() - 1);
}

std::string variable(const char* name)
{
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string peers_of(const std::string& list)
{
  std::string peers;
  for (std::size_t from = 0; from < list.size();)
  {
    const auto end = std::min(list.find(';', from), list.size());
    if (const auto peer = list.substr(from, end - from); !peer.empty())
    {
      if (peer.find_first_of("<>\"&") != std::string::npos)
        throw std::runtime_error("ROS_STATIC_PEERS: '" + peer + "' is no address");
      peers += "<Peer Address=\"" + peer + "\"/>";
    }
    from = end + 1;
  }
  return peers;
}

using Gid = std::string;
Gid gid_of(dds_entity_t entity)
{
  dds_guid_t guid{};
  dds_get_guid(entity, &guid);
  return {reinterpret_cast<const char*>(guid.v), sizeof guid.v};
}
}  // namespace

std::string configuration_of_environment()
{
  const std::string range = variable("ROS_AUTOMATIC_DISCOVERY_RANGE");
  static const std::set<std::string> kRanges = {"",    "SUBNET",  "LOCALHOST",
                                                "OFF", "NOT_SET", "SYSTEM_DEFAULT"};
  if (kRanges.count(range) == 0)
    throw std::runtime_error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE is '" + range + "'; it may be SUBNET, LOCALHOST or OFF");
  const bool is_local = range == "LOCALHOST" || variable("ROS_LOCALHOST_ONLY") == "1";
  std::string peers = peers_of(variable("ROS_STATIC_PEERS"));
  std::string general, discovery;
  if (is_local)
  {
    general = "<Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>";
    peers += "<Peer Address=\"127.0.0.1\"/>";
  }
  if (range == "OFF") general += "<AllowMulticast>false</AllowMulticast>";
  if (!peers.empty())
    discovery =
        "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32"
        "</MaxAutoParticipantIndex><Peers>" +
        peers + "</Peers>";
  const std::string own =
      "<CycloneDDS><Domain Id=\"any\"><General>" + general + "</General><Discovery>" + discovery +
      "</Discovery><Internal><SocketReceiveBufferSize min=\"default\" "
      "max=\"16MB\"/><MaxSampleSize>" +
      std::to_string(kMaxMessage_bytes) + "B</MaxSampleSize></Internal></Domain></CycloneDDS>";
  const std::string user = variable("CYCLONEDDS_URI");
  return user.empty() ? own : own + "," + user;
}

int domain_of_environment()
{
  constexpr int kMaxDomain = 232;
  const std::string text = variable("ROS_DOMAIN_ID");
  const auto number = text.empty() ? std::optional<double>(0) : number_from(text);
  if (!number || !(*number >= 0 && *number <= kMaxDomain) || *number != static_cast<int>(*number))
    throw std::runtime_error("ROS_DOMAIN_ID is '" + text + "', not a number from 0 to 232");
  return static_cast<int>(*number);
}

std::size_t max_receive_buffer()
{
  std::size_t bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> bytes;
  return bytes;
}

struct Participant::Impl
{
  Impl(int domain_id, const std::string& node)
      : domain(checked(
            dds_create_domain(
                static_cast<dds_domainid_t>(domain_id), configuration_of_environment().c_str()),
            "cannot join the network of ROS 2; see CYCLONEDDS_URI")),
        participant(checked(
            dds_create_participant(
                static_cast<dds_domainid_t>(domain_id), user_data().get(), nullptr),
            "cannot join the network of ROS 2")),
        waitset(checked(dds_create_waitset(participant), "waitset")),
        never(checked(dds_create_guardcondition(participant), "guard")),
        builtin(checked(
            dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
            "cannot see who publishes")),
        gid(gid_of(participant)),
        name(node)
  {
    dds_waitset_attach(waitset, never, 0);  // who waits for nothing at all does not wait
  }
  static Qos user_data()
  {
    const std::string enclave = "enclave=/;";  // by which ROS knows its own
    Qos qos(dds_create_qos());
    dds_qset_userdata(qos.get(), enclave.data(), enclave.size());
    return qos;
  }
  void note_offers();
  std::string nodes_message() const;

  Entity domain, participant, waitset, never, builtin;
  std::map<Gid, Offer> offers;  //!< of others, by their writer
  Gid gid;
  std::string name;
  std::set<Gid> readers, writers;
  std::unique_ptr<Publication> nodes;
  std::unique_ptr<Subscription> others;
  std::size_t gid_bytes = 16;  //!< before Iron 24
  std::string announced;
};

Participant::Participant(int domain, const std::string& node)
    : impl_(std::make_unique<Impl>(domain, node))
{
}
Participant::~Participant()
{
  impl_->nodes.reset();
  impl_->others.reset();
}

void Participant::Impl::note_offers()
{
  constexpr std::size_t kMaxOffers = 20000;
  void* sample = nullptr;
  dds_sample_info_t info;
  while (dds_take(builtin, &sample, &info, 1, 1) > 0)
  {
    const auto* e = static_cast<const dds_builtintopic_endpoint_t*>(sample);
    const Gid key(reinterpret_cast<const char*>(e->key.v), sizeof e->key.v);
    const bool is_own = std::memcmp(e->participant_key.v, gid.data(), 12) == 0;
    if (info.instance_state != DDS_IST_ALIVE)
      offers.erase(key);
    else if (
        info.valid_data && !is_own && offers.size() < kMaxOffers &&
        std::strncmp(e->topic_name, "rt/", 3) == 0)
    {
      Offer offer{e->topic_name + 2, type_in_ros(e->type_name), {}};
      dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
      dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
      dds_qget_reliability(e->qos, &reliability, nullptr);
      dds_qget_durability(e->qos, &durability);
      offer.quality.is_reliable = reliability == DDS_RELIABILITY_RELIABLE;
      offer.quality.is_kept = durability >= DDS_DURABILITY_TRANSIENT_LOCAL;
      offers[key] = offer;
    }
    dds_return_loan(builtin, &sample, 1);
    sample = nullptr;
  }
}

std::vector<Offer> Participant::offers()
{
  impl_->note_offers();
  std::map<std::pair<std::string, std::string>, Offer> by_name;
  for (const auto& [gid, offer] : impl_->offers)
  {
    const auto [at, is_new] = by_name.emplace(std::make_pair(offer.topic, offer.type), offer);
    at->second.quality.is_reliable &= offer.quality.is_reliable;
    at->second.quality.is_kept &= offer.quality.is_kept;
  }
  std::vector<Offer> all;
  all.reserve(by_name.size());
  for (auto& [name, offer] : by_name) all.push_back(std::move(offer));
  return all;
}

std::string Participant::Impl::nodes_message() const
{
  io::CdrWriter out;
  const auto put = [&](const Gid& id) { out.raw(id + std::string(gid_bytes - id.size(), '\0')); };
  const auto put_all = [&](const std::set<Gid>& ids)
  {
    out.put(static_cast<std::uint32_t>(ids.size()));
    for (const auto& id : ids) put(id);
  };
  put(gid);
  out.put(std::uint32_t{1});
  out.text("/");
  out.text(name);
  put_all(readers);
  put_all(writers);
  return out.bytes();
}

void Participant::announce()
{
  auto& me = *impl_;
  if (!me.nodes)
  {
    me.nodes = std::make_unique<Publication>(*this, kNodes, kNodesType, Quality{true, true, 1});
    me.others = std::make_unique<Subscription>(*this, kNodes, kNodesType, Quality{true, true, 10});
  }
  while (const auto message = me.others->take())
  {
    // A number of nodes is never 0 where more follows, so that these are the end of the identifier.
    const auto end = message->substr(std::min<std::size_t>(20, message->size()), 8);
    if (end.size() == 8) me.gid_bytes = end == std::string(8, '\0') ? 24 : 16;
  }
  std::string now = me.nodes_message();
  if (now == me.announced) return;
  me.announced = now;
  me.nodes->write(std::move(now));
}

bool Participant::wait(double max_s) const
{
  return dds_waitset_wait(impl_->waitset, nullptr, 0, static_cast<dds_duration_t>(max_s * 1e9)) > 0;
}

struct Subscription::Impl
{
  Impl(Participant::Impl& p, dds_entity_t t, const Quality& quality, const std::string& name)
      : participant(p),
        topic(t),
        reader(checked(
            dds_create_reader(p.participant, topic, qos_of(quality).get(), nullptr),
            "cannot subscribe to " + name)),
        gid(gid_of(reader))
  {
  }
  void release()
  {
    if (message) ddsi_serdata_unref(message);
    message = nullptr;
  }

  Participant::Impl& participant;
  Entity topic, reader;
  Gid gid;
  ddsi_serdata* message = nullptr;  //!< that was taken last
};

namespace
{
dds_entity_t make_topic(
    dds_entity_t participant, const std::string& name, const std::string& type,
    const ddsi_sertype** actual = nullptr)
{
  ddsi_sertype* raw = make_raw_type(type_in_dds(type));
  const auto topic = dds_create_topic_sertype(
      participant, name_in_dds(name).c_str(), &raw, nullptr, nullptr, nullptr);
  if (topic < 0)
  {
    ddsi_sertype_unref(raw);
    fail("topic " + name + " of " + type, topic);
  }
  if (actual) *actual = raw;
  return topic;
}
}  // namespace

Subscription::Subscription(
    Participant& participant, const std::string& topic, const std::string& type,
    const Quality& quality)
    : impl_(std::make_unique<Impl>(
          *participant.impl_, make_topic(participant.impl_->participant, topic, type), quality,
          topic))
{
  impl_->participant.readers.insert(impl_->gid);
  dds_set_status_mask(impl_->reader, DDS_DATA_AVAILABLE_STATUS);
  if (topic != kNodes) dds_waitset_attach(impl_->participant.waitset, impl_->reader, 0);
}

Subscription::~Subscription()
{
  impl_->release();
  impl_->participant.readers.erase(impl_->gid);
}

std::optional<std::string_view> Subscription::take()
{
  impl_->release();
  dds_sample_info_t info;
  while (dds_takecdr(impl_->reader, &impl_->message, 1, &info, DDS_ANY_STATE) > 0)
  {
    if (info.valid_data) return static_cast<RawMessage*>(impl_->message)->bytes;
    impl_->release();
  }
  return std::nullopt;
}

int Subscription::publishers() const
{
  dds_subscription_matched_status_t status{};
  dds_get_subscription_matched_status(impl_->reader, &status);
  return static_cast<int>(status.current_count);
}

std::size_t Subscription::lost() const
{
  dds_sample_lost_status_t status{};
  dds_get_sample_lost_status(impl_->reader, &status);
  return status.total_count;
}

struct Publication::Impl
{
  Impl(
      Participant::Impl& p, const std::string& name, const std::string& type_name, const Quality& q)
      : participant(p),
        topic(make_topic(p.participant, name, type_name, &type)),
        writer(checked(
            dds_create_writer(p.participant, topic, qos_of(q).get(), nullptr),
            "cannot publish " + name)),
        gid(gid_of(writer))
  {
  }

  Participant::Impl& participant;
  const ddsi_sertype* type = nullptr;
  Entity topic, writer;
  Gid gid;
};

Publication::Publication(
    Participant& participant, const std::string& topic, const std::string& type,
    const Quality& quality)
    : impl_(std::make_unique<Impl>(*participant.impl_, topic, type, quality))
{
  impl_->participant.writers.insert(impl_->gid);
}
Publication::~Publication() { impl_->participant.writers.erase(impl_->gid); }

void Publication::write(std::string message)
{
  const auto code = dds_writecdr(impl_->writer, make_raw_message(impl_->type, std::move(message)));
  if (code < 0 && code != DDS_RETCODE_TIMEOUT) fail("cannot publish", code);
}

int Publication::subscribers() const
{
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(impl_->writer, &status);
  return static_cast<int>(status.current_count);
}

void Publication::flush(double max_s) const
{
  dds_wait_for_acks(impl_->writer, static_cast<dds_duration_t>(max_s * 1e9));
}

}  // namespace talus::live
