#pragma once

namespace talus::app
{
/** Thrown when a signal asked the program to stop. */
struct Interrupted
{
  int signal;
};

/** While one lives, the first SIGINT, SIGTERM or SIGHUP is only noted, so that half-written files
 * can be removed; a second one ends the program at once. */
class Interrupt
{
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /** Throws Interrupted after a signal. */
  void check() const;
};

}  // namespace talus::app
