#pragma once
#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace talus
{
/** Whether a text ends with another one, or is the same. */
inline bool ends_with(std::string_view text, std::string_view ending)
{
  return text.size() >= ending.size() && text.substr(text.size() - ending.size()) == ending;
}

/** The pieces of a text between the characters of `separators`, also those that are empty. */
inline std::vector<std::string> pieces_of(const std::string& text, const char* separators)
{
  std::vector<std::string> pieces;
  for (std::size_t begin = 0; begin <= text.size();)
  {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    pieces.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return pieces;
}

/** The same text in small letters. */
inline std::string lower_case(std::string text)
{
  std::transform(
      text.begin(), text.end(), text.begin(),
      [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace talus
