#pragma once
// What the targets share. Each hands bytes straight to a reader, one input after the other in one
// process. A reader refuses by a std::exception. All else ends the run: a crash, a report of a
// sanitizer, an input that takes long or much memory (run.sh has the limits), a promise that what
// was read does not keep.
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

namespace talus::fuzz
{
/** Of a whole run, for run.sh: a target that never gets past the reader would look at nothing. */
struct ReadInputs
{
  std::size_t count = 0;
  ~ReadInputs() { std::fprintf(stderr, "stat::read_units: %zu\n", count); }
};
inline ReadInputs read_inputs;

/** Whether the reader took the input; false: it refused. */
template <class Read>
bool is_read(Read&& read)
{
  try
  {
    read();
    read_inputs.count++;
    return true;
  }
  catch (const std::exception& e)
  {
    if (std::getenv("TALUS_FUZZ_SHOW")) std::fprintf(stderr, "refused: %s\n", e.what());
    return false;
  }
}

/** What must hold of everything that was read. */
inline void require(bool holds, const char* promise)
{
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", promise);
  std::abort();
}

/** The input as a file, for readers that take a path; gone with this object. */
class InputFile
{
 public:
  /** `ending` with its point. */
  InputFile(const std::uint8_t* data, std::size_t size, const std::string& ending)
      : path_(
            std::filesystem::temp_directory_path() /
            ("talus_fuzz_" + std::to_string(getpid()) + ending))
  {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  }
  ~InputFile() { std::filesystem::remove(path_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace talus::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
