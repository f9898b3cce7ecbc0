#pragma once
#include "corrected_poses.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace talus::app
{
/** A trajectory file that another program writes anew. */
class WatchedTrajectory
{
 public:
  /** What is there already is of an earlier drive. */
  explicit WatchedTrajectory(const std::string& path);

  /** Its poses, once it was written anew and is whole. Throws std::runtime_error that names the
   * file and what is wrong, once for each time that it was written. */
  std::optional<Poses> take(double now_s);

 private:
  /** By which a file is another one. */
  struct State
  {
    std::filesystem::file_time_type time;
    std::uintmax_t bytes = 0;  //!< 0: there is none
    bool operator==(const State& o) const { return time == o.time && bytes == o.bytes; }
  };
  State now() const;
  bool ends_with_a_line() const;

  std::string path_;
  State taken_, last_;
  double last_s_ = 0;  //!< when that was new
};

}  // namespace talus::app
