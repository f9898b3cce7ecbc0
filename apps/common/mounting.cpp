#include "command_line.h"

#include <talus/number_text.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace talus::app
{
Mounting mounting_from_text(const std::string& text)
{
  constexpr double kFarthest_m = 100, kFullTurn_deg = 360;
  const std::string form =
      "; six numbers with commas are needed: " + std::string(kMountingForm) + " [m, degrees]";
  Mounting mounting{};
  std::size_t begin = 0;
  for (std::size_t i = 0; i < mounting.size(); ++i)
  {
    const bool is_last = i + 1 == mounting.size();
    const std::size_t end = is_last ? text.size() : text.find(',', begin);
    if (end == std::string::npos)
      throw std::invalid_argument("'" + text + "' has fewer than six numbers" + form);
    const double limit = i < 3 ? kFarthest_m : kFullTurn_deg;
    const std::string word = text.substr(begin, end - begin);
    const auto value = number_from(word);
    if (!value || !(std::abs(*value) <= limit))
      throw std::invalid_argument(
          "'" + word + "' in '" + text + "' is not a number in [-" + number_text(limit) + " - " +
          number_text(limit) + "]" + form);
    constexpr double kEighth_rad = 0.78539816339744831, kRounded = 6e-5;
    const double eighths = std::round(*value / kEighth_rad);
    if (i >= 3 && eighths != 0 && std::abs(eighths) <= 8 &&
        std::abs(*value - eighths * kEighth_rad) < kRounded)  // no angle that is measured is that
      throw std::invalid_argument(
          "'" + word + "' in '" + text +
          "' looks like radians, and degrees are needed: " + number_text(eighths * 45));
    mounting[i] = *value;
    begin = end + 1;
  }
  return mounting;
}

std::string text_of_mounting(const Mounting& m)
{
  char text[200];
  std::snprintf(
      text, sizeof text, "%.4f,%.4f,%.4f,%.3f,%.3f,%.3f", m[0], m[1], m[2], m[3], m[4], m[5]);
  return text;
}

}  // namespace talus::app
