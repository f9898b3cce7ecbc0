#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace talus::import
{
struct BagTopic
{
  std::string name, type;  //!< e.g. "/points", "sensor_msgs/msg/PointCloud2"
  std::string encoding;  //!< "cdr" in ROS 2
};

struct BagMessage
{
  std::size_t topic = 0;  //!< its index in topics()
  std::int64_t log_time_ns = 0;  //!< when it was recorded, since the epoch
};

/** No message and no chunk of a bag may have more bytes, unpacked: a count in a damaged file must
 * not take the memory of the machine. */
constexpr std::size_t kMaxBagBytes = std::size_t{1} << 27;

/** One file of a bag, message by message; only one is in memory. All throw std::runtime_error that
 * names the file and the place. */
class BagFile
{
 public:
  virtual ~BagFile() = default;

  const std::vector<BagTopic>& topics() const { return topics_; }

  /** Of the file. */
  virtual std::uint64_t bytes() const = 0;

  /** When its first message was recorded; nothing where there is none. */
  virtual std::optional<std::int64_t> first_ns() = 0;

  /** Messages, one number a topic; complete once all were read. */
  virtual std::vector<std::uint64_t> counts() const = 0;

  /** From the beginning, with one flag a topic. */
  void start(std::vector<bool> wanted)
  {
    wanted_ = std::move(wanted);
    rewind();
  }
  /** From the next message on. */
  void ignore(std::size_t topic) { wanted_[topic] = false; }

  /** In the order of log_time, as far as memory allows. False at the end. */
  virtual bool next(BagMessage& message) = 0;

  /** Of the last message; valid until next(). May be packed. */
  virtual std::string_view payload() = 0;

  /** Bytes of the file that hold the last message, be they packed. */
  virtual std::uint64_t stored_bytes() const = 0;

  /** Where the last message is, for errors: "FILE: message 7". */
  virtual std::string place() const = 0;

  /** Fraction read since start(), 0..1. */
  virtual double progress() const = 0;

  /** Frees memory and closes the file until the next start(). */
  virtual void stop() = 0;

  /** What a person should know of how it was read, a sentence each without its full stop. */
  virtual std::vector<std::string> remarks() const = 0;

 protected:
  bool is_wanted(std::size_t topic) const { return wanted_[topic]; }
  std::vector<BagTopic> topics_;

 private:
  virtual void rewind() = 0;
  std::vector<bool> wanted_;
};

/** By the first bytes of the file. `partial`: of one that is cut, what is before the cut. */
std::unique_ptr<BagFile> open_bag_file(const std::string& path, bool partial);

std::unique_ptr<BagFile> open_sqlite_bag(const std::string& path, bool partial);
std::unique_ptr<BagFile> open_mcap_bag(const std::string& path, bool partial);

}  // namespace talus::import
