#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace talus
{
/** Large memory gets large pages, and begins at a different offset in its page each time. Otherwise
 * a loop over ten arrays would need the same few lines of a cache for all of them. */
template <class T>
struct CellMemory
{
  using value_type = T;
  CellMemory() = default;
  template <class U>
  CellMemory(const CellMemory<U>&)
  {
  }

  T* allocate(std::size_t n)
  {
    static std::atomic<std::uintptr_t> next{0};
    if (n > PTRDIFF_MAX / sizeof(T) - 2 * kPage) throw std::bad_alloc();
    const std::size_t bytes = n * sizeof(T) + 2 * kPage;
    void* const block = ::operator new(bytes);
    const std::uintptr_t page = (reinterpret_cast<std::uintptr_t>(block) + kPage) / kPage * kPage;
    auto* const begin = reinterpret_cast<void**>(page + next.fetch_add(kStep) % kPage);
    begin[-1] = block;
#if defined(MADV_HUGEPAGE)
    if (bytes >= kLarge) madvise(reinterpret_cast<void*>(page), bytes - kPage, MADV_HUGEPAGE);
#endif
    return reinterpret_cast<T*>(begin);
  }
  void deallocate(T* begin, std::size_t) { ::operator delete(reinterpret_cast<void**>(begin)[-1]); }

  friend bool operator==(const CellMemory&, const CellMemory&) { return true; }
  friend bool operator!=(const CellMemory&, const CellMemory&) { return false; }

 private:
  static constexpr std::uintptr_t kPage = 4096, kStep = 11 * 64;
  static constexpr std::size_t kLarge = 1 << 20;
};

}  // namespace talus
