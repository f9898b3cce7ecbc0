#pragma once
#include <CLI/CLI.hpp>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace talus::app
{
/** A number from `low` to `high`. CLI::Range lets NaN through, which no comparison refuses. */
inline CLI::Validator between(double low, double high)
{
  std::ostringstream limits;
  limits << "[" << low << " - " << high << "]";
  const std::string in = limits.str();
  return CLI::Validator(
      [=](std::string& text)
      {
        double value = 0;
        const bool inside = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
        return inside ? std::string() : "'" + text + "' is not a number in " + in;
      },
      "FLOAT in " + in);
}

/** A whole number of 64 bits without sign. CLI11 takes the largest for one that is larger, and
 * wraps one that is negative. */
inline CLI::Validator whole_of_64_bits()
{
  return CLI::Validator(
      [](std::string& text)
      {
        char* end = nullptr;
        errno = 0;
        std::strtoull(text.c_str(), &end, 0);
        const bool fits = errno == 0 && end != text.c_str() && *end == '\0' &&
                          text.find('-') == std::string::npos;
        return fits ? std::string()
                    : "'" + text + "' is not a whole number from 0 to 18446744073709551615";
      },
      "");
}

/** A shell puts nothing in the place of a variable that is not set: that would count as not given.
 */
inline CLI::Validator not_empty()
{
  return CLI::Validator(
      [](std::string& text) { return text.empty() ? "is empty: an unset variable?" : ""; }, "");
}

/** Checks an option of six numbers: x, y, z [m], then three angles [degrees]. */
inline CLI::Option* check_mounting(CLI::Option* option)
{
  constexpr double kFarthest_m = 100, kFullTurn_deg = 360;
  for (int i = 0; i < 6; ++i)
  {
    const double limit = i < 3 ? kFarthest_m : kFullTurn_deg;
    option->check(between(-limit, limit).description("").application_index(i));
  }
  return option;
}

/** Throws std::runtime_error when a file that is to be written is one of those that are read. */
inline void require_apart(const std::string& output, const std::vector<std::string>& inputs)
{
  for (const std::string& input : inputs)
  {
    std::error_code none;
    if (!input.empty() && std::filesystem::equivalent(output, input, none))
      throw std::runtime_error(
          "'" + output + "' would be overwritten, but it is an input; write elsewhere");
  }
}

}  // namespace talus::app
