#pragma once
#include "drive_map.h"
#include "page_server.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace talus::app
{
/** The map of a drive that goes on, in browsers: the page of talus-export with the window on it. */
class LivePage
{
 public:
  /** Throws as PageServer does. */
  LivePage(const std::string& address, int port) : server_(address, port) {}
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  /** Serves it from now on; throws as formats::live_page(). */
  void begin(const std::string& title, double resolution_m);
  /** Takes what is new of the map, of which pictures are made in a thread of its own: a frame is
   * left out while that is busy, or where copies would take a twentieth of the time. */
  void update(DriveMap& map);

 private:
  using Clock = std::chrono::steady_clock;
  struct Square  //!< of a site, with what lies around it
  {
    site::TileKey key;
    io::LayerStack cells;
  };
  struct Event
  {
    std::string name, data;
  };
  /** For the thread. */
  struct Work
  {
    bool begins_anew = false;
    std::vector<Square> squares;
    std::vector<Event> path;
    io::LayerStack window;
    std::int64_t min_x = 0, min_y = 0;  //!< its first cell
    bool is_new = false;  //!< the window
    std::string robot;  //!< the other half of what is now
  };

  void look_for_new_map(DriveMap& map, Work& work);
  void take_window(const DriveMap& map, Work& work);
  void take_squares(DriveMap& map, Work& work);
  void take_path(const site::Site& site, Work& work);
  void wait_for_square(const site::TileKey& key);
  io::LayerStack square_of(site::Site& site, const site::TileKey& key) const;
  void put_window(const Work& work, Square& square) const;
  bool is_busy();
  void work();
  void show(const Work& work);

  PageServer server_;
  double resolution_m_ = 0;

  const site::Site* site_ = nullptr;  //!< of which is shown
  std::optional<int> floor_;
  std::size_t frames_ = 0;
  std::atomic<bool> is_behind_{false};  //!< the newest window was not shown
  bool is_reached_ = false;  //!< some cell: else reaching tells nothing
  std::uint64_t changes_ = 0;  //!< of tiles, that were looked at
  std::deque<site::TileKey> waiting_;
  std::set<site::TileKey> is_waiting_;
  std::map<site::TileKey, Clock::time_point> taken_;
  std::vector<std::size_t> points_;  //!< of each way, that are shown
  double driven_m_ = 0;
  Clock::time_point next_, shown_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Work> work_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace talus::app
