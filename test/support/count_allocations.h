#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

// Counts every allocation of the executable whose only source includes it, those of all threads.

namespace talus::test
{
inline std::atomic<std::uint64_t> allocations{0}, allocated_bytes{0};

inline void* counted(std::size_t size, std::size_t alignment = alignof(std::max_align_t))
{
  allocations++;
  allocated_bytes += size;
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  if (void* memory = std::aligned_alloc(alignment, whole ? whole : alignment)) return memory;
  throw std::bad_alloc();
}
}  // namespace talus::test

void* operator new(std::size_t size) { return talus::test::counted(size); }
void* operator new[](std::size_t size) { return talus::test::counted(size); }
void* operator new(std::size_t size, std::align_val_t a)
{
  return talus::test::counted(size, static_cast<std::size_t>(a));
}
void* operator new[](std::size_t size, std::align_val_t a)
{
  return talus::test::counted(size, static_cast<std::size_t>(a));
}
// One that is inlined looks to the compiler as if it freed what another had allocated.
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
