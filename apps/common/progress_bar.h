#pragma once
#include <chrono>
#include <string>

namespace talus::app
{
/** A line on the terminal that is drawn again and again; silent where stderr is not a terminal. */
class ProgressBar
{
 public:
  ProgressBar(std::string label, bool wanted);
  /** Removes the line. */
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /** `fraction` 0..1; drawn at most ten times a second. */
  void show(double fraction, const std::string& words);

 private:
  std::string label_;
  bool on_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace talus::app
