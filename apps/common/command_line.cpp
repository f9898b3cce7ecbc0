#include "command_line.h"

#include <talus/parameters.h>
#include <talus/number_text.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace talus::app
{
namespace
{
/** What is said of the first option that the program does not have; empty: it has them all. */
std::string unknown_option(const CLI::App& app)
{
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back(name);
  for (const std::string& word : app.remaining())
  {
    const auto begin = word.find_first_not_of('-');
    if (begin == 0 || begin == std::string::npos) continue;
    const std::string name = word.substr(begin, word.find('=') - begin);
    const std::string nearest = nearest_name(name, known);
    return "there is no option " + word.substr(0, word.find('=')) +
           (nearest.empty() ? "" : ", did you mean --" + nearest + "?");
  }
  return "";
}

/** The words of a text in lines of at most `columns`. */
std::string wrapped(const std::string& text, std::size_t columns)
{
  std::istringstream words(text);
  std::string all, line;
  for (std::string word; words >> word;)
  {
    if (!line.empty() && line.size() + 1 + word.size() > columns)
    {
      all += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return all + line;
}

/** Defaults in one form, at the end of what an option does, and no line of more than 100 columns.
 */
class HelpFormatter : public CLI::Formatter
{
 public:
  std::string make_option_opts(const CLI::Option* option) const override
  {
    std::string text = Formatter::make_option_opts(option);
    const std::string value = "=" + option->get_default_str();
    if (const auto at = text.find(value); value.size() > 1 && at != std::string::npos)
      text.erase(at, value.size());
    return text;
  }
  std::string make_option_desc(const CLI::Option* option) const override
  {
    constexpr std::size_t kColumns = 100;
    const std::string value = option->get_default_str();
    return wrapped(
        option->get_description() + (value.empty() ? "" : " (default: " + value + ")"),
        kColumns - get_column_width());
  }
};
}  // namespace

std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv)
{
  app.formatter(std::make_shared<HelpFormatter>());
  app.failure_message(
      [](const CLI::App* a, const CLI::Error& e)
      {
        const std::string name = a->get_name(), unknown = unknown_option(*a);
        return name + ": " + (unknown.empty() ? e.what() : unknown) + "\nRun '" + name +
               " --help' for usage.\n";
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

CLI::Option* add_mounting(
    CLI::App& app, const std::string& name, std::optional<Mounting>& value, const std::string& help)
{
  const auto read = [&value, name](const std::string& text)
  {
    try
    {
      value = mounting_from_text(text.substr(text.rfind('=') + 1));
    }
    catch (const std::invalid_argument& wrong)
    {
      throw CLI::ValidationError(name, wrong.what());
    }
  };
  return app.add_option_function<std::string>(name, read, help + " [m, degrees]")
      ->type_name("[LABEL=]" + std::string(kMountingForm));
}

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
