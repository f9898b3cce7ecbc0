#include <talus/number_text.h>

#include <charconv>
#include <limits>
#include <system_error>

namespace talus
{
namespace
{
std::string text_of(double value, std::chars_format format, int precision)
{
  // The greatest number has so many digits, a sign, a point and `decimals` more.
  std::string text(static_cast<std::size_t>(std::numeric_limits<double>::max_exponent10 + 8), '\0');
  text.resize(text.size() + static_cast<std::size_t>(precision));
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, format, precision);
  text.resize(static_cast<std::size_t>(end.ptr - text.data()));
  return text;
}
}  // namespace

std::optional<double> number_from(std::string_view text)
{
  const auto first = text.find_first_not_of(" \t\n\v\f\r");
  if (first == std::string_view::npos) return std::nullopt;
  text.remove_prefix(first);
  const bool has_plus = text.front() == '+' && text.substr(1, 1) != "-";  // from_chars() takes none
  if (has_plus) text.remove_prefix(1);
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return value;
}

std::string number_text(double value, int digits)
{
  return text_of(value, std::chars_format::general, digits);
}

std::string exact_number_text(double value)
{
  constexpr int kAlwaysExact = 17;
  for (int digits = 10; digits < kAlwaysExact; digits++)
    if (std::string text = number_text(value, digits); number_from(text) == value) return text;
  return number_text(value, kAlwaysExact);
}

std::string fixed_text(double value, int decimals)
{
  return text_of(value, std::chars_format::fixed, decimals);
}

}  // namespace talus
