#include "copy_large.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif
#if defined(TALUS_HAVE_TBB)
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
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

#if defined(TALUS_HAVE_TBB)
constexpr int kThreads = 4;
constexpr std::size_t kAlone = 256 * 1024;  //!< less is not worth waking threads for
constexpr std::size_t kPiece = 64 * 1024;

/** Blocks cut into pieces, of which each thread takes the next. */
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
  /** Tells of the blocks that are there. */
  void tell(const std::function<void(int)>& done)
  {
    for (; told_ < count_ && left_[told_].load(std::memory_order_acquire) == 0; told_++)
      done(told_);
  }

 private:
  int pieces(int b) const { return static_cast<int>((blocks_[b].to_copy() + kPiece - 1) / kPiece); }

  const CopyBlock* blocks_;
  int count_, pieces_ = 0, told_ = 0;
  std::atomic<int> next_{0}, left_[kMaxCopyBlocks];
};

void copy_together(const CopyBlock* blocks, int count, const std::function<void(int)>& done)
{
  static tbb::task_arena arena(kThreads);
  SharedCopy copy(blocks, count);
  const auto work = [&](int thread)
  {
    if (thread == 0)
      copy.work([&] { copy.tell(done); });
    else
      copy.work([] {});
  };
  arena.execute([&] { tbb::parallel_for(0, kThreads, work, tbb::static_partitioner()); });
  copy.tell(done);
}
#endif
}  // namespace

void copy_blocks(const CopyBlock* blocks, int count, const std::function<void(int)>& done)
{
#if defined(TALUS_HAVE_TBB)
  std::size_t bytes = 0;
  for (int b = 0; b < count; b++) bytes += blocks[b].to_copy();
  if (bytes > kAlone)
  {
    copy_together(blocks, count, done);
    return;
  }
#endif
  for (int b = 0; b < count; b++)
  {
    copy_part(blocks[b], 0, blocks[b].to_copy());
    done(b);
  }
}

}  // namespace talus
