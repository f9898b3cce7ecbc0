#pragma once
#include <CLI/CLI.hpp>
#include <talus/formats/write.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace talus::app
{
/** In what formats a map is written, and how. */
struct ExportOptions
{
  std::vector<std::string> formats;  //!< as the option --to names them
  std::string changes;  //!< a changes.tif for the page; empty: none
  formats::RosMode ros_mode = formats::RosMode::Trinary;
  formats::Occupancy occupancy{0.0, 0.5};
  double clearance_m = 0.6;
  std::optional<formats::FileOrigin>
      origin;  //!< of occupancy, ply and octomap; nothing: origin_for()
  std::size_t max_faces = 2'000'000, max_mb = 30;
};

/** The files of a map: of a site also its other floors and islands. Throws std::runtime_error where
 * one cannot be read. */
std::vector<std::string> files_of_map(const std::string& geotiff);

/** The files that export_files() may write. */
std::vector<std::string> files_of_export(
    const std::vector<std::string>& map, const std::string& folder, const ExportOptions& options);

/** Throws std::runtime_error where a format needs what is not installed here. */
void require_exportable(const ExportOptions& options);

/** What was written, and what was not. */
struct Exported
{
  std::vector<std::string> notes, errors;  //!< each names its file
};

/** Writes the files of a map in each of the formats into a folder. What is written is called as the
 * file is. `title`: of the page. What fails costs no other file. */
Exported export_files(
    const std::vector<std::string>& map, const std::string& folder, const std::string& title,
    const ExportOptions& options);

/** Adds an option of this name that takes formats, with commas between them. */
CLI::Option* add_formats(
    CLI::App& app, const std::string& name, ExportOptions& options, const std::string& help);

}  // namespace talus::app
