#include "run_app.h"

#include "child_process.h"
#include "command_line.h"
#include "crash_context.h"
#include "printable.h"

#include <iostream>

namespace talus::app
{
namespace
{
std::string& name_of_command()
{
  static std::string name;
  return name;
}
}  // namespace

int run_app(
    const std::string& name, int argc, char** argv, const std::function<void(CLI::App&)>& add,
    const std::function<int()>& body)
{
  const PrintableOutput printable;
  name_of_command() = name;
  CLI::App app{"", name};
  add(app);
  app.set_version_flag("--version", version_line(name));
  if (const auto code = parse_command_line(app, argc, argv)) return *code;
  try
  {
    forward_signals();  // before any folder is made: a signal must not leave it behind
    return body();
  }
  catch (const std::exception& e)
  {
    print_error(failure_text(e, "this run", "Give it less at once"));
    return 1;
  }
}

void print_error(const std::string& text)
{
  std::cerr << name_of_command() << ": " << printable(text) << "\n";
}
}  // namespace talus::app
