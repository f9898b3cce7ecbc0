#pragma once
#include "mounting.h"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

namespace talus::app
{
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

/** Adds an option that takes a mounting; empty while it is not given. */
CLI::Option* add_mounting(
    CLI::App& app, const std::string& name, std::optional<Mounting>& value,
    const std::string& help);

}  // namespace talus::app
