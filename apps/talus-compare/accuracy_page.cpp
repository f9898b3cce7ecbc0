#include <talus/input_file.h>

#include <cstdint>
#include <filesystem>
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
  namespace fs = std::filesystem;
  constexpr std::uint64_t kMost_bytes = 16 << 20;
  std::error_code none;
  const bool is_new = !fs::exists(path, none);
  if (is_new || (fs::is_regular_file(path, none) && fs::file_size(path, none) == 0)) return {};
  const std::string all = read_input_file(path, "page (--markdown)", kMost_bytes);
  const auto marker = all.find(kMarker);
  if (marker == std::string::npos)
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
