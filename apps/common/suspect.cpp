#include "suspect.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>
#include <string>

namespace talus::app
{
namespace
{
/** What a process and its children see both. */
struct Shared
{
  char file[4096], advice[256];  // paths are no longer
};

Shared* new_shared()
{
  void* const page =
      ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) throw std::bad_alloc();
  return static_cast<Shared*>(page);  // of zeros, and for as long as the process lives
}

Shared*& place_of_shared()
{
  static Shared* place = new_shared();
  return place;
}
Shared& shared() { return *place_of_shared(); }

/** Cut where it is too long; its end is there at any moment. */
template <std::size_t N>
void put(const std::string& text, char (&where)[N])
{
  const std::size_t length = std::min(text.size(), N - 1);
  where[0] = '\0';
  if (length == 0) return;
  std::memcpy(where + 1, text.data() + 1, length - 1);
  where[length] = '\0';
  where[0] = text[0];
}

void note(const std::string& file, const std::string& advice)
{
  put(advice, shared().advice);
  put(file, shared().file);
}
}  // namespace

Suspect::Suspect(const std::string& file, const std::string& advice) : before_(newest())
{
  note(file, advice);
}

Suspect::~Suspect() { note(before_.file, before_.advice); }

Suspect::Named Suspect::newest() { return {shared().file, shared().advice}; }

void Suspect::be_alone() { place_of_shared() = new_shared(); }

void Suspect::forget() { note({}, {}); }

std::string failure_text(
    const std::exception& e, const std::string& file, const std::string& advice)
{
  if (!dynamic_cast<const std::bad_alloc*>(&e)) return e.what();
  return file + ": needs more memory than there is. " + advice;
}

int code_of(
    const std::function<int()>& work, const std::function<void(const std::string&)>& tell,
    const std::string& file, const std::string& advice)
{
  try
  {
    return work();
  }
  catch (const std::exception& e)
  {
    tell(failure_text(e, file, advice));
    return 1;
  }
}

}  // namespace talus::app
