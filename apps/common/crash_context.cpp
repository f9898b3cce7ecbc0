#include "crash_context.h"

#include <sys/mman.h>

#include <cstdio>

namespace talus::app
{
namespace
{
/** What a process and its children see both. */
struct Note
{
  char file[4096], advice[256];  // paths are no longer
};

/** Of zeros. */
Note* new_note()
{
  void* const page =
      ::mmap(nullptr, sizeof(Note), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) throw std::bad_alloc();
  return static_cast<Note*>(page);
}

Note*& shared_note()
{
  static Note* note = new_note();
  return note;
}

void write(const CrashContext::Named& named)
{
  Note& note = *shared_note();
  std::snprintf(note.advice, sizeof note.advice, "%s", named.advice.c_str());
  std::snprintf(note.file, sizeof note.file, "%s", named.file.c_str());
}
}  // namespace

CrashContext::CrashContext(const std::string& file, const std::string& advice) : before_(newest())
{
  write({file, advice});
}

CrashContext::~CrashContext() { write(before_); }

CrashContext::Named CrashContext::newest() { return {shared_note()->file, shared_note()->advice}; }

void CrashContext::begin_anew()
{
  Note* const fresh = new_note();
  ::munmap(shared_note(), sizeof(Note));
  shared_note() = fresh;
}

std::string failure_text(
    const std::exception& e, const std::string& file, const std::string& advice)
{
  if (!dynamic_cast<const std::bad_alloc*>(&e)) return e.what();
  return file + ": needs more memory than there is. " + advice;
}

}  // namespace talus::app
