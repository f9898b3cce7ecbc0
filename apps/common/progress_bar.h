#pragma once
#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace talus::app
{
/** Tells from fractions of a job and the times [s] of a clock how long it still takes. */
class TimeLeft
{
 public:
  /** "40 s left", or "" while nothing can be told. A fraction that falls begins another job. */
  std::string text(double fraction, double now_s);

 private:
  double first_ = 0, last_ = 2, begin_s_ = 0;
};

/** A line on the terminal that is drawn again and again; silent where stderr is not a terminal. Or
 * lines that are sent to another process, which draws them beside those of others. */
class ProgressBar
{
 public:
  ProgressBar(const std::string& label, bool wanted);
  /** Removes the line. */
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /** `fraction` 0..1; drawn at most ten times a second. */
  void show(double fraction, const std::string& words);

  /** From now on the bars of this process are written here, a line of SharedLines. */
  static void send_to(char* line);

 private:
  std::string label_;
  bool on_;
  std::chrono::steady_clock::time_point last_{};
  TimeLeft left_;
};

/** A line for each of several processes, which they write and the process that made them reads. */
class SharedLines
{
 public:
  static constexpr std::size_t kSize = 512;

  /** Throws std::bad_alloc. */
  explicit SharedLines(std::size_t count);
  ~SharedLines();
  SharedLines(const SharedLines&) = delete;
  SharedLines& operator=(const SharedLines&) = delete;

  /** Of kSize bytes. */
  char* at(std::size_t i) { return begin_ + i * kSize; }
  /** Those that are not empty. */
  std::vector<std::string> shown() const;

 private:
  std::size_t count_;
  char* begin_;
};

/** The bars of several processes, one below the other; silent where stderr is not a terminal. */
class ProgressLines
{
 public:
  explicit ProgressLines(bool wanted);
  ~ProgressLines() { remove(); }
  ProgressLines(const ProgressLines&) = delete;
  ProgressLines& operator=(const ProgressLines&) = delete;

  /** Drawn at most ten times a second, and no more of them than find room. */
  void show(const std::vector<std::string>& lines);
  /** Before something else is printed. */
  void remove();

 private:
  bool on_;
  std::size_t drawn_ = 0;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace talus::app
