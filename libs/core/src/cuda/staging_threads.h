#pragma once
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace talus
{
/** Threads that join in short work of some ten microseconds, for which sleeping threads wake up too
 * late. While work is frequent they wait for it awake, else they sleep. Nobody waits for a helper
 * that has not come. */
class StagingThreads
{
 public:
  explicit StagingThreads(int count);
  ~StagingThreads();

  /** Runs `own` on this thread and meanwhile `help` on helpers, which returns when nothing is left
   * to do. Returns, or throws the exception of `own`, when no helper is in it any longer. Wakes
   * sleeping helpers if the work is long or frequent. Has no helpers while they work for another
   * thread. */
  void work(const std::function<void()>& own, const std::function<void()>& help, bool is_long);

 private:
  void begin(const std::function<void()>& help, bool is_long);
  void end();
  void serve();
  /** Waits for work after round `seen`. */
  void wait_for_work(unsigned seen);

  std::mutex turn_;  //!< held by the thread that they work for
  const std::function<void()>* help_ = nullptr;
  std::atomic<bool> open_{false};  //!< there is work to join
  std::atomic<int> inside_{0};  //!< helpers that are in the work, or about to be
  std::atomic<unsigned> round_{0};
  std::atomic<long long> last_ns_{0};  //!< when the last work came
  std::atomic<bool> often_{false};

  std::mutex sleep_;
  std::condition_variable wake_;
  std::atomic<int> asleep_{0};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace talus
