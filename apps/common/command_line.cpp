#include "command_line.h"

#include <talus/parameters.h>

#include <cerrno>
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

}  // namespace talus::app
