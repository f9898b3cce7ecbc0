#include <gtest/gtest.h>
#include "cuda/copy_large.h"

#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace talus;

namespace
{
/** Three blocks of odd sizes, the last one in place. */
class Blocks
{
 public:
  explicit Blocks(std::size_t bytes, int seed)
  {
    for (std::size_t b = 0; b < 2; b++)
    {
      from_[b].resize(bytes + 13 * b);
      to_[b].resize(from_[b].size(), '?');
      for (std::size_t i = 0; i < from_[b].size(); i++)
        from_[b][i] = static_cast<char>(i * 31 + b + static_cast<std::size_t>(seed));
      blocks_[b] = {to_[b].data(), from_[b].data(), from_[b].size()};
    }
    blocks_[2] = {to_[0].data(), to_[0].data(), bytes};
  }
  /** Copies, and says whether each block was there, in order, when it was told of. */
  bool copy() const
  {
    int next = 0;
    bool right = true;
    copy_blocks(
        blocks_, 3,
        [&](int b)
        {
          right &= b == next++;
          const CopyBlock& block = blocks_[b];
          right &= std::memcmp(block.to, block.from, block.bytes) == 0;
        });
    return right && next == 3;
  }
  const CopyBlock* data() const { return blocks_; }

 private:
  std::vector<char> from_[2], to_[2];
  CopyBlock blocks_[3];
};

constexpr std::size_t kSmall = 1000, kMedium = 50'000, kLarge = 1'500'001;
}  // namespace

TEST(CopyLarge, TellsOfEachBlockInOrderWhenItIsThereAlsoAfterARest)
{
  for (const std::size_t bytes : {kSmall, kMedium, kLarge})
    for (int i = 0; i < 50; i++)
    {
      if (i % 10 == 9) std::this_thread::sleep_for(std::chrono::milliseconds(5));  // helpers rest
      EXPECT_TRUE(Blocks(bytes, i).copy()) << bytes << ", " << i;
    }
}

TEST(CopyLarge, OfSeveralThreadsAtOnce)
{
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; t++)
    threads.emplace_back(
        [t]
        {
          for (int i = 0; i < 30; i++) EXPECT_TRUE(Blocks(kLarge, 100 * t + i).copy());
        });
  for (std::thread& t : threads) t.join();
}

TEST(CopyLarge, AnErrorOfWhoIsToldReachesTheCallerAndTheNextCopyWorks)
{
  for (int i = 0; i < 20; i++)
  {
    const Blocks some(kLarge, i);
    EXPECT_THROW(
        copy_blocks(some.data(), 3, [](int) { throw std::runtime_error("no"); }),
        std::runtime_error);
    EXPECT_TRUE(Blocks(kLarge, i).copy());
  }
}
