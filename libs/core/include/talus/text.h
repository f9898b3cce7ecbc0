#pragma once
#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace talus
{
/** Whether a text ends with another one, or is the same. */
inline bool ends_with(std::string_view text, std::string_view ending)
{
  return text.size() >= ending.size() && text.substr(text.size() - ending.size()) == ending;
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
