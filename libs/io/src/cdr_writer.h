#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace talus::io
{
/** Serializes the fields of one message of ROS 2, in their order, as plain CDR. */
class CdrWriter
{
 public:
  /** A number, at a multiple of its size. */
  template <class T>
  void put(T value)
  {
    array(&value, 1);
  }
  /** Numbers of a fixed count. */
  template <class T>
  void array(const T* values, std::size_t count)
  {
    if (count == 0) return;
    bytes_.resize((bytes_.size() + sizeof(T) - 1 - kHead) / sizeof(T) * sizeof(T) + kHead);
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  /** Numbers with their count before them. */
  template <class T>
  void sequence(const T* values, std::size_t count)
  {
    put(static_cast<std::uint32_t>(count));
    array(values, count);
  }
  /** With its length, and a zero at its end. */
  void text(std::string_view text)
  {
    put(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.append(text).push_back('\0');
  }
  /** As they are. */
  void raw(std::string_view bytes) { bytes_.append(bytes); }

  /** All so far, with the encapsulation. */
  std::string bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kHead = 4;  //!< from whose end on alignment counts
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
  std::string bytes_ = std::string("\0\0\0\0", kHead);
#else
  std::string bytes_ = std::string("\0\1\0\0", kHead);
#endif
};

}  // namespace talus::io
