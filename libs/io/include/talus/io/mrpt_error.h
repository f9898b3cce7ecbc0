#pragma once
#include <exception>
#include <string>

namespace talus::io
{
/** What an exception says, in one line: MRPT puts a title, places in its sources, a stack trace
 * and the exceptions of outer functions around the message of the innermost one. */
inline std::string reason_of(const std::exception& e)
{
  const std::string text = e.what();
  std::size_t begin = 0;
  for (const std::string mark : {"==== MRPT exception ====", "Message:"})
    if (const auto at = text.rfind(mark); at != std::string::npos) begin = at + mark.size();
  begin = text.find_first_not_of(" \t\n", begin);
  if (begin == std::string::npos) return "no reason given";
  const auto line = text.substr(begin, text.find('\n', begin) - begin);
  return line.substr(0, line.find(" from mrpt::"));  // the description of its stream
}

}  // namespace talus::io
