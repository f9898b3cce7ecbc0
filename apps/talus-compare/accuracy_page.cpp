#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

#include "report.h"

namespace talus::baselines
{
namespace
{
const std::string kMarker = "<!-- below: written by talus-compare --markdown -->";

/** What people wrote above the marker; the marker itself not. */
std::string hand_written(const std::string& path)
{
  std::string all;
  bool is_read = false;
  std::ifstream in(path, std::ios::binary);
  try
  {
    all.assign(std::istreambuf_iterator<char>(in), {});
    is_read = in.is_open();
  }
  catch (const std::ios_base::failure&)
  {
  }
  std::error_code none;
  if (!is_read && std::filesystem::exists(path, none))
    throw std::runtime_error(
        "'" + path + "' cannot be read, and what it says would be lost; give another --markdown");
  const auto marker = all.find(kMarker);
  if (marker == std::string::npos && !all.empty())
    throw std::runtime_error(
        "'" + path + "' is no page of talus-compare; give another --markdown, or add the line '" +
        kMarker + "' to it: what stands below that line is replaced");
  return all.substr(0, marker);
}

}  // namespace

std::string accuracy_page(const std::string& old_page, const Comparison& c)
{
  return hand_written(old_page) + kMarker + "\n\nMade by `" + c.command + "`. " +
         std::to_string(failed_budgets(c)) + " budgets do not hold (marked `!`).\n\n" +
         tables_markdown(c);
}

}  // namespace talus::baselines
