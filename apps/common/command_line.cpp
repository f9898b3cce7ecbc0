#include "command_line.h"

#include <cerrno>
#include <cstdlib>
#include <sstream>

namespace talus::app
{
std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv)
{
  app.failure_message(
      [](const CLI::App* a, const CLI::Error& e)
      {
        const std::string name = a->get_name();
        return name + ": " + e.what() + "\nRun '" + name + " --help' for usage.\n";
      });
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::ParseError& e)
  {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return std::nullopt;
}

CLI::Validator between(double low, double high)
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

CLI::Validator whole_of_64_bits()
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

CLI::Validator not_empty()
{
  return CLI::Validator(
      [](std::string& text) { return text.empty() ? "is empty: an unset variable?" : ""; }, "");
}

CLI::Option* check_mounting(CLI::Option* option)
{
  constexpr double kFarthest_m = 100, kFullTurn_deg = 360;
  for (int i = 0; i < 6; ++i)
  {
    const double limit = i < 3 ? kFarthest_m : kFullTurn_deg;
    option->check(between(-limit, limit).description("").application_index(i));
  }
  return option;
}

}  // namespace talus::app
