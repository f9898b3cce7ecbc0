#include "printable.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <iostream>

namespace talus::app
{
namespace
{
std::uint8_t byte_at(std::string_view text, std::size_t i)
{
  return static_cast<std::uint8_t>(text[i]);
}

/** How many bytes the character takes that begins with this one, 0: none begins so. */
std::size_t length_of(std::uint8_t first)
{
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (first >= 0xE0 && first < 0xF0) return 3;
  return first >= 0xF0 && first < 0xF5 ? 4 : 0;
}

/** Whether all bytes are there and mean something: no longer form of a shorter one, no half of a
 * pair of UTF-16, nothing beyond Unicode. */
bool is_whole(std::string_view character)
{
  const auto is_next = [](char c) { return (static_cast<std::uint8_t>(c) & 0xC0) == 0x80; };
  if (!std::all_of(character.begin() + 1, character.end(), is_next)) return false;
  if (character.size() < 3) return true;
  const auto first = byte_at(character, 0), second = byte_at(character, 1);
  return !(first == 0xE0 && second < 0xA0) && !(first == 0xED && second > 0x9F) &&
         !(first == 0xF0 && second < 0x90) && !(first == 0xF4 && second > 0x8F);
}

bool is_control(std::string_view character)
{
  const auto first = byte_at(character, 0);
  if (character.size() == 2) return first == 0xC2 && byte_at(character, 1) < 0xA0;
  return character.size() == 1 &&
         (first == 0x7F || (first < 0x20 && first != '\n' && first != '\t'));
}

/** Whether a character of UTF-8 goes on with this byte. */
bool goes_on(std::string_view text, std::size_t i)
{
  return i < text.size() && (byte_at(text, i) & 0xC0) == 0x80;
}

/** Without its middle where it is longer than `most`. */
std::string without_middle(std::string_view part, std::size_t most)
{
  if (part.size() <= most) return std::string(part);
  std::size_t first = most / 2, last = part.size() - most / 4;
  while (first > 0 && goes_on(part, first)) --first;
  while (goes_on(part, last)) ++last;
  return std::string(part.substr(0, first)) + "...(" + std::to_string(last - first) + " more)..." +
         std::string(part.substr(last));
}

/** The same for each part between separators. */
std::string each_without_middle(
    std::string_view text, std::string_view separators, std::size_t most)
{
  std::string all;
  while (!text.empty())
  {
    const std::size_t end = std::min(text.find_first_of(separators), text.size());
    all += without_middle(text.substr(0, end), most) + std::string(text.substr(end, 1));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return all;
}

/** Passes each piece of text that is written on to another buffer. */
class PrintableBuffer : public std::streambuf
{
 public:
  explicit PrintableBuffer(std::streambuf* to) : to_(to) {}

 protected:
  std::streamsize xsputn(const char* text, std::streamsize size) override
  {
    const std::string shown = printable(shortened({text, static_cast<std::size_t>(size)}));
    const auto length = static_cast<std::streamsize>(shown.size());
    return to_->sputn(shown.data(), length) == length ? size : 0;
  }
  int_type overflow(int_type c) override
  {
    const char one = traits_type::to_char_type(c);
    const bool is_none = traits_type::eq_int_type(c, traits_type::eof());
    return is_none || xsputn(&one, 1) == 1 ? traits_type::not_eof(c) : traits_type::eof();
  }
  int sync() override { return to_->pubsync(); }

 private:
  std::streambuf* to_;
};
}  // namespace

std::string shortened(std::string_view text)
{
  constexpr std::size_t kLongestWord = 400, kLongestLine = 2000;
  return each_without_middle(each_without_middle(text, " \t\n", kLongestWord), "\n", kLongestLine);
}

std::string printable(std::string_view text)
{
  std::string shown;
  while (!text.empty())
  {
    const std::size_t length = length_of(byte_at(text, 0));
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    const bool is_text =
        length > 0 && character.size() == length && is_whole(character) && !is_control(character);
    char code[8];
    std::snprintf(code, sizeof code, "\\x%02x", byte_at(text, 0));
    shown += is_text ? character : code;
    text.remove_prefix(is_text ? length : 1);
  }
  return shown;
}

PrintableOutput::PrintableOutput()
{
  for (auto* stream : {&std::cout, &std::cerr, &std::clog})
  {
    auto buffer = std::make_unique<PrintableBuffer>(stream->rdbuf());
    auto* before = stream->rdbuf(buffer.get());
    streams_.push_back({stream, before, std::move(buffer)});
  }
}

PrintableOutput::~PrintableOutput()
{
  for (const auto& s : streams_)
  {
    s.stream->flush();
    s.stream->rdbuf(s.before);
  }
}

}  // namespace talus::app
