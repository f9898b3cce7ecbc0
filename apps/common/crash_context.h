#pragma once
#include "memory_limit.h"

#include <cstddef>
#include <functional>
#include <new>
#include <stdexcept>
#include <string>

namespace talus::app
{
/** While one lives, a crash of this process is put down to a file: MRPT may crash over what is
 * damaged or makes no sense. Of several that live the newest counts; the parent of a child that
 * crashed sees it too. Of the whole process: not for two threads at once. */
class CrashContext
{
 public:
  /** `advice`: what to do, a sentence without its full stop. */
  CrashContext(const std::string& file, const std::string& advice);
  ~CrashContext();
  CrashContext(const CrashContext&) = delete;
  CrashContext& operator=(const CrashContext&) = delete;

  struct Named
  {
    std::string file, advice;  //!< empty: there is none
  };
  /** The newest that lives, here or in the child that ran last, or that lived when it crashed. */
  static Named newest();
  /** Before a child is started: forgets that of a child before. From now on this process and the
   * children that it starts note theirs apart from all others. */
  static void begin_anew();

 private:
  Named before_;
};

/** For files: what a person can do about a damaged one. */
constexpr const char* kCompareWithSource = "It is probably damaged: compare it with its source";
constexpr const char* kLookAtLog =
    "It is probably damaged: compare it with its source, or look at it with rawlog-edit --info";

/** More than any file needs. */
constexpr std::size_t kMaxMemory_bytes = std::size_t{2} << 30;

/** Does what a wrong file may lead astray: with no more than `max_bytes` of memory beyond what it
 * has, and so that a crash and want of memory are put down to that file. Throws std::runtime_error
 * for want of memory, and what `work` throws. */
template <class F>
auto guarded(
    const std::string& file, const std::string& advice, const F& work,
    std::size_t max_bytes = kMaxMemory_bytes)
{
  const CrashContext context(file, advice);
  const MemoryLimit limit(max_bytes);
  try
  {
    return work();
  }
  catch (const std::bad_alloc&)
  {
    throw std::runtime_error(
        file + ": needs more memory than there is, or than a file of its size can need. " + advice);
  }
}

/** The message of an exception. One for want of memory says nothing of its own: it is put down to
 * `file`, with `advice`. */
std::string failure_text(
    const std::exception& e, const std::string& file, const std::string& advice);

/** What `work` returns; 1 where it throws, of which failure_text() is reported. */
int code_of(
    const std::function<int()>& work, const std::function<void(const std::string&)>& report,
    const std::string& file, const std::string& advice);

}  // namespace talus::app
