#pragma once
#include <chrono>
#include <string>

namespace talus::app
{
/** Estimates from fractions of a job and the times [s] of a clock how long it still takes. */
class TimeLeft
{
 public:
  /** "40 s left", or "" while nothing is known. A fraction that falls begins another job. */
  std::string text(double fraction, double now_s);

 private:
  double first_ = 0, last_ = 2, begin_s_ = 0;
};

/** A line on the terminal that is drawn again and again; silent where stderr is not a terminal. */
class ProgressBar
{
 public:
  ProgressBar(const std::string& label, bool wanted);
  /** Removes the line. */
  ~ProgressBar() { remove(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /** `fraction` 0..1; drawn at most ten times a second. */
  void show(double fraction, const std::string& words);
  /** Before something else is printed. */
  void remove();

  /** From now on the bars of this process are not drawn: their fractions are written here. */
  static void send_to(double* fraction);

 private:
  std::string label_;
  bool on_;
  std::chrono::steady_clock::time_point last_{};
  TimeLeft left_;
};

}  // namespace talus::app
