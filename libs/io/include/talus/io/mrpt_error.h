#pragma once
#include <exception>
#include <string>

namespace talus::io
{
/** What an exception says, in one line: MRPT puts places in its sources, a stack trace and the
 * exceptions of outer functions around the message of the innermost one. */
inline std::string reason_of(const std::exception& e)
{
  const std::string text = e.what();
  const std::string mark = "Message:";
  const auto at = text.rfind(mark);
  const auto begin =
      text.find_first_not_of(" \t\n", at == std::string::npos ? 0 : at + mark.size());
  if (begin == std::string::npos) return "no reason given";
  const auto line = text.substr(begin, text.find('\n', begin) - begin);
  return line.substr(0, line.find(" from mrpt::"));  // the description of its stream
}

}  // namespace talus::io
