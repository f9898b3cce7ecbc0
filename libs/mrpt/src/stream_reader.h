#pragma once
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace talus::detail
{
/** Reads the parts of an object out of a stream that may be cut short, damaged or made up, where
 * MRPT's operators would allocate what a length says and take what is not there for read. Memory
 * grows only with the bytes that arrive. All functions throw std::runtime_error that names the
 * object and `what`. */
class StreamReader
{
 public:
  StreamReader(mrpt::serialization::CArchive& in, std::string object);

  [[noreturn]] void fail(const std::string& what) const;

  /** As operator<< writes it. */
  template <typename T>
  T number(const char* what)
  {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    T value{};
    if (in_.ReadBufferFixEndianness(&value, 1) != sizeof value) fail(what);
    return value;
  }
  bool flag(const char* what);
  std::string text(std::size_t longest, const char* what);
  std::vector<std::uint8_t> bytes(std::uint64_t size, const char* what);
  /** A pose whose numbers are finite. */
  mrpt::poses::CPose3D pose(const char* what);

 private:
  mrpt::serialization::CArchive& in_;
  std::string object_;
};
}  // namespace talus::detail
