#pragma once
#include <talus/import/scan_stream.h>
#include <talus/live/network.h>

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace talus::app
{
/** Hears what a stream of scans can use, of all that a robot publishes. */
class Topics
{
 public:
  /** `wanted`: topics with clouds; empty: all. `path`: that of corrected poses; empty: none. */
  Topics(
      live::Participant& network, const std::vector<std::string>& wanted, const std::string& path);

  /** Subscribes to what is new, and leaves what is of no use. What to tell of it. */
  std::vector<std::string> look(const import::ScanStream& stream);
  /** Gives the stream all that has come, clouds last. */
  void take_into(import::ScanStream& stream, double now_s);

  /** Corrected poses, where they have come: the newest ones. Throws std::runtime_error. */
  std::optional<import::StreamPath> take_path();
  /** The messages that the network has lost, as far as it knows. */
  std::size_t lost() const;

  /** The bytes of the largest message so far. */
  std::size_t max_bytes() const { return max_bytes_; }
  /** Why nothing comes; empty: something is published. */
  std::string why_nothing() const;

 private:
  struct Heard
  {
    std::string topic, type;
    std::unique_ptr<live::Subscription> messages;
    bool is_reliable = false;  //!< then who is not is not heard
    bool is_cloud = false, is_path = false;
  };
  void choose_robot();
  bool is_settled() const;
  bool is_of_other_robot(const live::Offer& offer) const;
  bool is_wanted(const live::Offer& offer) const;
  void take_into(import::ScanStream& stream, Heard& heard, double now_s);

  live::Participant& network_;
  std::vector<std::string> wanted_;
  std::string path_;
  std::map<std::string, Heard> heard_;  //!< by topic
  std::vector<live::Offer> offers_;  //!< of the last look
  std::set<std::string> told_;
  std::set<std::string> robots_;  //!< that have TF of their own, by their namespaces
  std::optional<std::string> robot_;  //!< that is mapped, once that is known
  int looks_ = 0;
  std::size_t max_bytes_ = 0;
};

}  // namespace talus::app
