#include "export_files.h"

#include "export_formats.h"

namespace talus::app
{
CLI::Option* add_formats(
    CLI::App& app, const std::string& name, ExportOptions& options, const std::string& help)
{
  std::vector<std::string> names;
  for (const ExportFormat& format : export_formats()) names.push_back(format.name);
  return app.add_option(name, options.formats, help)
      ->delimiter(',')
      ->check(
          [](const std::string& format) {
            return format == "gridmap" ? "gridmap: MRPT's occupancy grid is called occupancy" : "";
          })
      ->check(CLI::IsMember(names))
      ->type_name("FORMAT,...");
}

}  // namespace talus::app
