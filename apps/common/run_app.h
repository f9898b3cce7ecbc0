#pragma once
#include <functional>
#include <string>

namespace CLI
{
class App;
}

namespace talus::app
{
/** main() of a command: reads the command line, to which `add` adds description, options and footer
 * (parse_command_line()), and does `body` with signals forwarded to its children. What `body`
 * throws is printed, and 1 the exit code. */
int run_app(
    const std::string& name, int argc, char** argv, const std::function<void(CLI::App&)>& add,
    const std::function<int()>& body);

/** The same of a struct of options, whose namespace has add_options(). */
template <class Options>
int run_app(const std::string& name, int argc, char** argv, int (*body)(const Options&))
{
  Options options;
  return run_app(
      name, argc, argv, [&](CLI::App& app) { add_options(app, options); },
      [&] { return body(options); });
}

/** Prints "NAME: TEXT" of that command to stderr, in one line. */
void print_error(const std::string& text);

/** What `--version` says, in one line: "talus-map 0.1.0 (commit ea309eb, backends cpu and cuda)".
 */
std::string version_line(const std::string& command);

}  // namespace talus::app
