#pragma once
#include <memory>
#include <string>

namespace talus::app
{
/** Serves one page and what changes on it, as events, to browsers. Of each thing that changes only
 * what is newest is kept, once for all: who reads slowly gets less often what he reads, and holds
 * nobody up. */
class PageServer
{
 public:
  static constexpr int kMaxListeners = 16;  //!< more pages at a time are refused

  /** `address`: of this machine, 127.0.0.1 is heard by itself only. Throws std::runtime_error where
   * the port is in use, or this build has no server. */
  PageServer(const std::string& address, int port);
  /** Ends all connections at once. */
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /** Serves it from now on; before, nothing is. `run` names it: its events begin with that. */
  void begin(const std::string& page, const std::string& run);
  /** What `kind` is from now on: its newest event. */
  void show_now(const std::string& data);
  /** What belongs to the map, by a name of its own; `kind` of the event. */
  void keep(const std::string& name, const std::string& kind, const std::string& data);
  /** Another map begins: what was kept is forgotten. */
  void forget();

  /** How many pages are open. */
  int listeners() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::app
