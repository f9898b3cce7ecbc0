#include "export_files.h"

namespace talus::app
{
CLI::Option* add_formats(
    CLI::App& app, const std::string& name, ExportOptions& options, const std::string& help)
{
  return app.add_option(name, options.formats, help)
      ->delimiter(',')
      ->check(CLI::IsMember({"ros", "gridmap", "octomap", "ply", "heightmap", "qgis", "html"}))
      ->type_name("FORMAT,...");
}

}  // namespace talus::app
