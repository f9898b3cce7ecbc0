#pragma once
#include <talus/text.h>

#include <string>
#include <vector>

namespace talus::app
{
/** A format of exports. */
struct ExportFormat
{
  std::string name;  //!< as the option --to names it
  std::vector<std::string>
      endings;  //!< of its files, after the name of the map; the first is the main one
  std::vector<std::string> bands;  //!< that it shows, besides channels
  bool has_origin = false;  //!< its coordinates have 32 bits
};

/** All that there are, in the order of the help. */
inline const std::vector<ExportFormat>& export_formats()
{
  static const std::vector<ExportFormat> formats{
      {"ros", {".yaml", ".pgm", "_scale.png"}, {"traversability"}},
      {"occupancy", {".gridmap.gz"}, {"traversability"}, true},
      {"gridmap",
       {"_gridmap.mcap"},
       {"elevation", "ground_elevation", "traversability", "variance", "state"}},
      {"octomap", {".bt"}, {"traversability", "ground_elevation", "elevation", "state"}, true},
      {"ply", {".ply", "_mesh.json"}, {"traversability", "ground_elevation", "elevation"}, true},
      {"heightmap", {"_height.png", "_height.json"}, {"ground_elevation"}},
      {"qgis", {".qml"}, {"traversability"}},
      {"html",
       {".html"},
       {"traversability", "ground_elevation", "elevation", "state", "reached", "sparsity", "age"}}};
  return formats;
}

/** Whether a file of this name is the main one of its format. */
inline bool is_main_file(const std::string& name)
{
  for (const ExportFormat& format : export_formats())
    if (const std::string& end = format.endings.front();
        name.size() > end.size() && ends_with(name, end))
      return true;
  return false;
}

}  // namespace talus::app
