#pragma once
#include <CLI/CLI.hpp>

#include <array>
#include <optional>
#include <string>
#include <type_traits>

namespace talus::app
{
/** Where a sensor is mounted, as CPose3D counts: x, y, z [m], yaw, pitch, roll [degrees]. */
using Mounting = std::array<double, 6>;

/** How --help names such a value, which all commands take alike. */
constexpr const char* kMountingForm = "X,Y,Z,YAW,PITCH,ROLL";

/** Reads six numbers with commas between them; throws std::invalid_argument, which says what is
 * wrong. */
Mounting mounting_from_text(const std::string& text);

/** The text that mounting_from_text() reads: to 0.1 mm and 0.001 degrees. */
std::string text_of_mounting(const Mounting& mounting);

/** Reads the command line; answers --help, --version and mistakes itself, a misspelt option by the
 * one that is nearest. The exit code of the program, or nothing: go on. */
std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv);

/** Adds an option whose value stays empty when it is not given. */
template <typename T>
CLI::Option* add_optional(
    CLI::App& app, const std::string& name, std::optional<T>& value, const std::string& help)
{
  return app.add_option_function<T>(
      name, [&value](const T& v) { value = v; }, help);
}

/** A number from `low` to `high`. CLI::Range lets NaN through, which no comparison refuses. */
CLI::Validator between(double low, double high);

/** A whole number of 64 bits without sign. CLI11 takes the largest for one that is larger, and
 * wraps one that is negative. */
CLI::Validator whole_of_64_bits();

/** A shell puts nothing in the place of a variable that is not set: that would count as not given.
 */
CLI::Validator not_empty();

/** Adds an option that takes a text, which may not be empty. */
inline CLI::Option* add_text(
    CLI::App& app, const std::string& name, std::string& value, const std::string& type,
    const std::string& help)
{
  return app.add_option(name, value, help)->check(not_empty())->type_name(type);
}

/** Adds an option that takes a number from `low` to `high`; the help shows its default. */
template <typename T, typename Limit>
CLI::Option* add_number(
    CLI::App& app, const std::string& name, T& value, Limit low, Limit high,
    const std::string& type, const std::string& help)
{
  const bool is_whole = std::is_integral_v<T>;
  return app.add_option(name, value, help)
      ->check(is_whole ? CLI::Validator(CLI::Range(low, high)) : between(low, high))
      ->capture_default_str()
      ->type_name(type);
}

/** Adds an option, `type` as --help names its value, which the check must let through. */
template <typename T>
CLI::Option* add_checked(
    CLI::App& app, const std::string& name, T& value, const std::string& help, const char* type,
    const CLI::Validator& check)
{
  return app.add_option(name, value, help)->check(check)->type_name(type);
}
template <typename T>
CLI::Option* add_checked(
    CLI::App& app, const std::string& name, std::optional<T>& value, const std::string& help,
    const char* type, const CLI::Validator& check)
{
  return add_optional(app, name, value, help)->check(check)->type_name(type);
}

/** Adds an option that takes a mounting of the one sensor, whose label may stand before it; empty
 * while it is not given. */
CLI::Option* add_mounting(
    CLI::App& app, const std::string& name, std::optional<Mounting>& value,
    const std::string& help);

}  // namespace talus::app
