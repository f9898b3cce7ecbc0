#include "cuda/copy_large.h"
#include "cuda/staging_threads.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <thread>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace talus
{
namespace
{
void copy_past_caches(char* to, const char* from, std::size_t bytes)
{
  std::size_t streamed = 0;
#if defined(__SSE2__)
  constexpr std::size_t kStep = 64, kWord = sizeof(__m128i);
  if (reinterpret_cast<std::uintptr_t>(to) % kWord == 0) streamed = bytes / kStep * kStep;
  for (std::size_t i = 0; i < streamed; i += kStep)
    for (std::size_t w = i; w < i + kStep; w += kWord)
      _mm_stream_si128(
          reinterpret_cast<__m128i*>(to + w),
          _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + w)));
  _mm_sfence();
#endif
  std::memcpy(to + streamed, from + streamed, bytes - streamed);
}

void copy_part(const CopyBlock& block, std::size_t begin, std::size_t size)
{
  copy_past_caches(
      static_cast<char*>(block.to) + begin, static_cast<const char*>(block.from) + begin,
      std::min(size, block.to_copy() - begin));
}

constexpr int kMaxHelpers = 5;
/** A smaller copy is done alone; below the second size threads are not woken. */
constexpr std::size_t kAlone = 96 * 1024, kLarge = 256 * 1024;
constexpr std::size_t kPiece = 32 * 1024;

/** Blocks in pieces; each thread takes the next one. */
class SharedCopy
{
 public:
  SharedCopy(const CopyBlock* blocks, int count) : blocks_(blocks), count_(count)
  {
    for (int b = 0; b < count; b++) left_[b] = pieces(b), pieces_ += left_[b];
  }

  /** Copies pieces while there are any; calls `after()` after each. */
  template <class F>
  void work(const F& after)
  {
    for (int i; (i = next_.fetch_add(1)) < pieces_; after())
    {
      int b = 0;
      for (; i >= pieces(b); b++) i -= pieces(b);
      copy_part(blocks_[b], kPiece * static_cast<std::size_t>(i), kPiece);
      left_[b].fetch_sub(1, std::memory_order_release);
    }
  }
  /** Calls `done` for the blocks that are complete. */
  void report(const std::function<void(int)>& done)
  {
    for (; reported_ < count_ && left_[reported_].load(std::memory_order_acquire) == 0; reported_++)
      done(reported_);
  }

 private:
  int pieces(int b) const { return static_cast<int>((blocks_[b].to_copy() + kPiece - 1) / kPiece); }

  const CopyBlock* blocks_;
  int count_, pieces_ = 0, reported_ = 0;
  std::atomic<int> next_{0}, left_[kMaxCopyBlocks];
};

int helper_count()
{
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()) - 1, 0, kMaxHelpers);
}

void copy_together(
    const CopyBlock* blocks, int count, bool large, const std::function<void(int)>& done)
{
  static StagingThreads helpers(helper_count());
  SharedCopy copy(blocks, count);
  helpers.work([&] { copy.work([&] { copy.report(done); }); }, [&] { copy.work([] {}); }, large);
  copy.report(done);
}
}  // namespace

void copy_blocks(const CopyBlock* blocks, int count, const std::function<void(int)>& done)
{
  std::size_t bytes = 0;
  for (int b = 0; b < count; b++) bytes += blocks[b].to_copy();
  if (bytes > kAlone)
  {
    copy_together(blocks, count, bytes > kLarge, done);
    return;
  }
  for (int b = 0; b < count; b++)
  {
    copy_part(blocks[b], 0, blocks[b].to_copy());
    done(b);
  }
}

}  // namespace talus
