// A robot whose DDS is that of another vendor, the default one of ROS 2.
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <chrono>
#include <cstring>
#include <memory>
#include <thread>

#include "robot.h"

namespace fast = eprosima::fastdds::dds;
namespace wire = eprosima::fastrtps::rtps;

namespace
{
/** Samples are strings, serialized already. */
class Bytes : public fast::TopicDataType
{
 public:
  explicit Bytes(const char* name)
  {
    setName(name);
    m_typeSize = 1 << 20;
    m_isGetKeyDefined = false;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }
  bool serialize(void* data, wire::SerializedPayload_t* out) override
  {
    const auto& bytes = *static_cast<std::string*>(data);
    std::memcpy(out->data, bytes.data(), bytes.size());
    out->length = static_cast<std::uint32_t>(bytes.size());
    out->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(wire::SerializedPayload_t*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override
  {
    const auto size = static_cast<std::uint32_t>(static_cast<std::string*>(data)->size());
    return [size] { return size; };
  }
  void* createData() override { return new std::string(); }
  void deleteData(void* data) override { delete static_cast<std::string*>(data); }
  bool getKey(void*, wire::InstanceHandle_t*, bool) override { return false; }
};

fast::DomainParticipant* on_loopback(int domain)
{
  fast::DomainParticipantQos qos;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back("127.0.0.1");
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  for (int i = 0; i < 5; ++i)
  {
    wire::Locator_t peer;
    wire::IPLocator::setIPv4(peer, 127, 0, 0, 1);
    peer.port = static_cast<std::uint32_t>(7410 + 250 * domain + 2 * i);
    qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  }
  return fast::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<fast::DomainId_t>(domain), qos);
}

fast::DataWriter* writer_of(
    fast::DomainParticipant* participant, fast::Publisher* publisher, const char* topic,
    const char* type, bool is_kept)
{
  fast::TypeSupport(new Bytes(type)).register_type(participant);
  fast::DataWriterQos qos;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind =
      is_kept ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
  qos.history().depth = 20;
  qos.publish_mode().kind = fast::ASYNCHRONOUS_PUBLISH_MODE;
  qos.endpoint().history_memory_policy = wire::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return publisher->create_datawriter(
      participant->create_topic(topic, type, fast::TOPIC_QOS_DEFAULT), qos);
}

void wait_for_listener(fast::DataWriter* writer)
{
  fast::PublicationMatchedStatus status;
  for (int i = 0; i < 1000 && status.current_count == 0; ++i)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    writer->get_publication_matched_status(status);
  }
}
}  // namespace

int main()
{
  using namespace talus::test;
  const char* domain = std::getenv("ROS_DOMAIN_ID");
  auto* participant = on_loopback(domain ? std::atoi(domain) : 0);
  auto* publisher = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
  const char* tf_type = "tf2_msgs::msg::dds_::TFMessage_";
  auto* tf_static = writer_of(participant, publisher, "rt/tf_static", tf_type, true);
  auto* tfs = writer_of(participant, publisher, "rt/tf", tf_type, false);
  auto* clouds =
      writer_of(participant, publisher, "rt/points", "sensor_msgs::msg::dds_::PointCloud2_", false);
  const auto say = [](fast::DataWriter* writer, std::string message) { writer->write(&message); };
  for (auto* writer : {tf_static, tfs, clouds}) wait_for_listener(writer);
  say(tf_static, tf(0, "base_link", "lidar", 0, 0.5));
  for (int i = 0; i <= 8; ++i)
  {
    say(tfs, tf(0.1 * i, "map", "base_link", 0.1 * i));
    say(clouds, floor_cloud(0.1 * i));
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  clouds->wait_for_acknowledgments({2, 0});
  fast::DomainParticipantFactory::get_instance()->delete_participant(participant);
  std::puts("published");
}
