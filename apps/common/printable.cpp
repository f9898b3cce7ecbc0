#include "printable.h"

#include <algorithm>
#include <cstdio>

namespace talus::app
{
std::string printable(std::string_view text, std::string_view kept)
{
  // U+0080 to U+009F in UTF-8: 0xC2 and one of these bytes.
  const auto at = [&](std::size_t i) { return i < text.size() ? text[i] & 0xFF : 0; };
  const auto is_second = [&](std::size_t i) { return at(i) >= 0x80 && at(i) < 0xA0; };
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i)
  {
    const bool is_ascii_control =
        (at(i) < 0x20 || at(i) == 0x7F) && kept.find(text[i]) == kept.npos;
    const bool is_half_of_control =
        (at(i) == 0xC2 && is_second(i + 1)) || (is_second(i) && i > 0 && at(i - 1) == 0xC2);
    char code[8];
    std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned>(at(i)));
    shown += is_ascii_control || is_half_of_control ? code : std::string(1, text[i]);
  }
  return shown;
}

std::string shortened(std::string_view text)
{
  constexpr std::size_t kLongest = 400, kFirst = 200, kLast = 100;
  std::string all;
  while (!text.empty())
  {
    const std::size_t end = std::min(text.find_first_of(" \t\n"), text.size());
    const std::string word(text.substr(0, end));
    all += end <= kLongest
               ? word
               : word.substr(0, kFirst) + "...(" + std::to_string(end - kFirst - kLast) +
                     " more)..." + word.substr(end - kLast);
    all += text.substr(end, 1);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return all;
}

PrintableBuffer::~PrintableBuffer()
{
  stream_.flush();
  stream_.rdbuf(to_);
}

std::streamsize PrintableBuffer::xsputn(const char* text, std::streamsize size)
{
  const std::string shown = printable(shortened({text, static_cast<std::size_t>(size)}), "\t\n");
  const auto length = static_cast<std::streamsize>(shown.size());
  return to_->sputn(shown.data(), length) == length ? size : 0;
}

PrintableBuffer::int_type PrintableBuffer::overflow(int_type c)
{
  const char one = traits_type::to_char_type(c);
  const bool is_none = traits_type::eq_int_type(c, traits_type::eof());
  return is_none || xsputn(&one, 1) == 1 ? traits_type::not_eof(c) : traits_type::eof();
}

}  // namespace talus::app
