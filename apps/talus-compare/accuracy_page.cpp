#include <talus/io/atomic_file.h>

#include <fstream>
#include <sstream>

#include "report.h"

namespace talus::baselines
{
namespace
{
const std::string kMarker = "<!-- below: written by talus-compare --markdown -->\n";

/** What people wrote above the marker; the marker itself not. */
std::string hand_written(const std::string& path)
{
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  const std::string all = text.str();
  return all.substr(0, all.find(kMarker));
}

}  // namespace

void write_accuracy_page(const std::string& path, const Comparison& c)
{
  io::write_file(
      path, hand_written(path) + kMarker + "\nMade by `" + c.command + "`. " +
                std::to_string(failed_budgets(c)) + " budgets do not hold (marked `!`).\n\n" +
                tables_markdown(c));
}

}  // namespace talus::baselines
