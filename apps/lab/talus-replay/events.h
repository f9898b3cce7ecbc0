#pragma once
#include <talus/live/network.h>

#include <memory>
#include <string>

namespace talus::app
{
/** A message that is to be published. */
struct Event
{
  double time_s = 0;  //!< when, by the clock of the recording
  std::string topic, type;  //!< as ROS names them
  bool is_kept = false;  //!< who comes later gets it, too
  std::string message;  //!< serialized
};

/** The messages of a recording, in the order of time. */
class Events
{
 public:
  virtual ~Events() = default;
  /** False at the end. Throws std::runtime_error that names the file and what is wrong. */
  virtual bool next(Event& event) = 0;
};

/** The messages of a bag, all as they are. */
std::unique_ptr<Events> events_of_bag(const std::string& path);

/** How a rawlog becomes topics. */
struct RawlogTopics
{
  std::string trajectory;  //!< empty: beside the log, or within it
  bool as_odometry = false;  //!< poses as nav_msgs/Odometry, not as TF
  std::string slam;  //!< a trajectory, by which a SLAM corrects these poses; empty: none does
  double slam_every_s = 60;  //!< how often
};

/** The scans of a rawlog as clouds on topics with the labels of their sensors, its poses as frame
 * base_link in map, and its mountings. */
std::unique_ptr<Events> events_of_rawlog(const std::string& path, const RawlogTopics& options);

}  // namespace talus::app
