#pragma once
#include <iostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace talus::app
{
/** A text as a terminal shows it and does not obey it: control characters that are not among `kept`
 * become `\xNN`, also in names, which may have line breaks. */
std::string printable(std::string_view text, std::string_view kept = "\t");

/** A text whose words of more than 400 bytes have lost their middle: what was wrong in a file or on
 * a command line is shown, and may be of any length. */
std::string shortened(std::string_view text);

/** While one lives, all that goes to a stream passes shortened() and printable(), line breaks kept.
 */
class PrintableBuffer : public std::streambuf
{
 public:
  explicit PrintableBuffer(std::ostream& stream) : stream_(stream), to_(stream.rdbuf(this)) {}
  ~PrintableBuffer() override;
  PrintableBuffer(const PrintableBuffer&) = delete;
  PrintableBuffer& operator=(const PrintableBuffer&) = delete;

 protected:
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int_type overflow(int_type c) override;
  int sync() override { return to_->pubsync(); }

 private:
  std::ostream& stream_;
  std::streambuf* to_;
};

/** The same for std::cout, std::cerr and std::clog: names of files, sensors and classes, and values
 * come from whoever made the file. Make it first in main(). */
struct PrintableOutput
{
  PrintableBuffer out{std::cout}, err{std::cerr}, log{std::clog};
};

}  // namespace talus::app
