#pragma once
#include <cstddef>
#include <functional>

namespace talus
{
/** A copy of `bytes`; source and destination may be the same. */
struct CopyBlock
{
  void* to;
  const void* from;
  std::size_t bytes;

  std::size_t to_copy() const { return to == from ? 0 : bytes; }
};

/** Copies blocks into memory that a device reads next: past the caches, from which the bus would
 * have to fetch, and by several threads, since one core is slower than the bus. One thread at a
 * time calls `done(i)` once for each block, in order, as soon as it is complete. */
constexpr int kMaxCopyBlocks = 4;
void copy_blocks(const CopyBlock* blocks, int count, const std::function<void(int)>& done);

}  // namespace talus
