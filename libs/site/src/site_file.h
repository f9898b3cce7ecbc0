#pragma once
#include <talus/site/site_geotiff.h>

#include <cstddef>
#include <string>
#include <vector>

namespace talus::site
{
/** What a file has of a site, and which others are written with it. */
struct FileOfFloor
{
  int floor;
  std::vector<int> floors;  //!< of the site
  std::size_t islands;  //!< of the floor beside this file
};

/** As write_site(), of a site that has no tiles but those of the file. */
void write_site_file(
    const std::string& path, Site& site, const FileOfFloor& file, const Progress& progress);

}  // namespace talus::site
