#pragma once
#include <cstddef>
#include <memory>
#include <string_view>

namespace talus::io
{
/** Bytes still to be read. */
struct Bytes
{
  const char* begin = nullptr;
  std::size_t size = 0;
};
/** Memory still to be filled. */
struct Room
{
  char* begin = nullptr;
  std::size_t size = 0;
};

/** One way to pack a file. */
class Unpacker
{
 public:
  virtual ~Unpacker() = default;

  /** For messages: "gz" or "zstd", empty for a file that is not packed. */
  virtual const char* name() const = 0;

  /** Unpacks from one to the other, and leaves in both what is left. Throws std::runtime_error with
   * the reason when the data is damaged. */
  virtual void unpack(Bytes& from, Room& to) = 0;

  /** Whether the data before is whole, so that the file may end here. */
  virtual bool may_end() const = 0;

  /** Whether data could go on so; asked where may_end() and some data came before. */
  virtual bool may_go_on_with(std::string_view begin) const = 0;
};

/** By the first bytes of a file. */
std::unique_ptr<Unpacker> make_unpacker(std::string_view begin);

}  // namespace talus::io
