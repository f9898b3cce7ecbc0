#include "crash_context.h"
#include "log_name.h"

#include <talus/io/rawlog_reader.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>

namespace talus::app
{
namespace
{
constexpr std::uint64_t kMegabyte = 1U << 20;
constexpr std::uint64_t kMaxLog_bytes = 2048 * kMegabyte, kMinLogShare_bytes = 256 * kMegabyte;
constexpr std::uint64_t kMaxExtra_bytes = 100 * kMegabyte, kMinExtraShare_bytes = 8 * kMegabyte;
constexpr std::uint64_t kHeldByAByte = 64;  // of a picture or a line of poses; points take 1 to 3

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;  // takes memory of its own
#elif defined(__has_feature)
constexpr bool kIsSanitized = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
constexpr bool kIsSanitized = false;
#endif

std::uint64_t processes = 1;
}  // namespace

std::size_t memory_for_log(const std::string& path)
{
  const std::uint64_t max = std::max(kMaxLog_bytes / processes, kMinLogShare_bytes);
  const std::uint64_t more = std::max(kMaxExtra_bytes / processes, kMinExtraShare_bytes);
  const std::uint64_t bytes = std::min(io::bytes_of_log(path), kMaxLog_bytes);
  return kIsSanitized ? kMaxLog_bytes : std::min(max, more + kHeldByAByte * bytes);
}

void share_log_memory(std::size_t at_once) { processes = std::max<std::uint64_t>(at_once, 1); }

io::Trajectory poses_of_log(const std::string& log, const std::string& given, std::string* source)
{
  std::error_code none;
  const std::string beside = trajectory_beside(log);
  if (given.empty() && !std::filesystem::exists(beside, none))
    return guarded(
        log, kLookAtLog, [&] { return io::trajectory_from_rawlog(log, source); },
        memory_for_log(log));
  const std::string& file = given.empty() ? beside : given;
  if (source) *source = file;
  return guarded(
      file, kCompareWithSource, [&] { return io::Trajectory::load(file); }, memory_for_log(file));
}

}  // namespace talus::app
