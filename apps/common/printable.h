#pragma once
#include <memory>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

namespace talus::app
{
/** A text as a terminal shows it and does not obey it: control characters other than the end of a
 * line and a tab, and bytes that are no UTF-8, become `\xNN`. */
std::string printable(std::string_view text);

/** A text whose words of more than 400 bytes, and then lines of more than 2,000, have lost their
 * middle: what was wrong in a file or on a command line is shown, and may be of any length. */
std::string shortened(std::string_view text);

/** While one lives, all that goes to std::cout, std::cerr and std::clog passes shortened() and
 * printable(): names of files, sensors and classes, and values, come from whoever made the file.
 * Make it first in main(). */
class PrintableOutput
{
 public:
  PrintableOutput();
  ~PrintableOutput();
  PrintableOutput(const PrintableOutput&) = delete;
  PrintableOutput& operator=(const PrintableOutput&) = delete;

 private:
  struct Redirected
  {
    std::ostream* stream;
    std::streambuf* before;
    std::unique_ptr<std::streambuf> buffer;
  };
  std::vector<Redirected> streams_;
};

}  // namespace talus::app
