#pragma once
#include <cstddef>
#include <functional>

namespace talus
{
/** `bytes` from one place to another, which may be the same. */
struct CopyBlock
{
  void* to;
  const void* from;
  std::size_t bytes;

  std::size_t to_copy() const { return to == from ? 0 : bytes; }
};

/** Copies up to kMaxCopyBlocks blocks into memory that a device reads next: past the caches, from
 * which the bus would have to fetch it back, and where they are large by several threads, since one
 * core does not keep up with the bus. `done(i)` is called once for each
 * block, in order, as soon as it is there; by one thread at a time. */
constexpr int kMaxCopyBlocks = 4;
void copy_blocks(const CopyBlock* blocks, int count, const std::function<void(int)>& done);

}  // namespace talus
