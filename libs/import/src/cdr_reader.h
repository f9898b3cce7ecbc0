#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace talus::import
{
/** What is wrong with a message, for a sentence that begins with its place. */
class CdrError : public std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/** The fields of one serialized ROS 2 message, in their order. All throw CdrError where the message
 * is too short. */
class CdrReader
{
 public:
  /** `message` with its four bytes of encapsulation; must outlive this. Throws where these say
   * another encoding than plain CDR. */
  explicit CdrReader(std::string_view message);
  ~CdrReader();
  CdrReader(const CdrReader&) = delete;
  CdrReader& operator=(const CdrReader&) = delete;

  bool flag();
  std::uint8_t u8();
  std::int32_t i32();
  std::uint32_t u32();
  std::uint64_t u64();
  double f64();
  std::string string();

  /** The length of a sequence whose elements take at least `min_bytes` each. */
  std::uint32_t count(std::size_t min_bytes);

  /** A sequence of bytes, where it lies in the message. */
  std::string_view bytes();

  /** All that is left, where it lies. */
  std::string_view rest();

 private:
  template <class T>
  T number();

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::import
