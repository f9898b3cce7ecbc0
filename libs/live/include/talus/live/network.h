#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/** A participant of the network of ROS 2, without ROS: DDS with the names and the encoding that ROS
 * gives it. Messages are bytes, as they are serialized (plain CDR, with its four bytes of
 * encapsulation). */
namespace talus::live
{
/** What a subscription asks for, and a publication offers. */
struct Quality
{
  bool is_reliable = true;  //!< else lost messages stay lost, as of most sensors
  bool is_kept = false;  //!< who comes later gets the last messages, too: transient local
  int depth = 10;  //!< messages that wait to be taken, or are kept
};

/** A topic that somebody publishes. */
struct Offer
{
  /** As ROS names them: "/points", "sensor_msgs/msg/PointCloud2". */
  std::string topic, type;
  Quality quality;  //!< what all of its publishers offer; its depth is not known
};

/** The configuration of Cyclone DDS that the environment asks for: ROS_LOCALHOST_ONLY,
 * ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS and, before all, CYCLONEDDS_URI. Throws
 * std::runtime_error where one of them is wrong. */
std::string configuration_of_environment();

/** ROS_DOMAIN_ID, else 0. Throws std::runtime_error where it is wrong. */
int domain_of_environment();

/** The largest receive buffer that a socket gets here [bytes]; 0: not known. */
std::size_t max_receive_buffer();

/** Who takes part. Not thread safe. */
class Participant
{
 public:
  /** `node`: its name, as `ros2 node list` shows it. Throws std::runtime_error that says what to
   * do. */
  Participant(int domain, const std::string& node);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /** What others publish now, by its topic and type. */
  std::vector<Offer> offers();

  /** Tells others which node has these publications and subscriptions, and listens how they say it
   * of themselves; to be called now and then. */
  void announce();

  /** Waits for a message of any of its subscriptions, or until this time [s] has passed; true for a
   * message. */
  bool wait(double max_s) const;

 private:
  friend class Subscription;
  friend class Publication;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Messages of one topic. */
class Subscription
{
 public:
  /** Throws std::runtime_error that says what to do. */
  Subscription(
      Participant& participant, const std::string& topic, const std::string& type,
      const Quality& quality);
  ~Subscription();
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;

  /** The next message, where one has come; valid until the next call. */
  std::optional<std::string_view> take();
  /** How many publish the topic now. */
  int publishers() const;
  /** How many messages the network has lost so far, as far as it knows. */
  std::size_t lost() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** A topic of its own. */
class Publication
{
 public:
  /** Throws std::runtime_error that says what to do. */
  Publication(
      Participant& participant, const std::string& topic, const std::string& type,
      const Quality& quality);
  ~Publication();
  Publication(const Publication&) = delete;
  Publication& operator=(const Publication&) = delete;

  /** Throws std::runtime_error. */
  void write(std::string message);
  /** How many listen now. */
  int subscribers() const;
  /** Waits until all who listen have got all, or this time [s] has passed. */
  void flush(double max_s) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::live
