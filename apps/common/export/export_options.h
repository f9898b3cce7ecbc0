#pragma once
#include <CLI/CLI.hpp>

#include <string>

#include "export_files.h"

namespace talus::app
{
/** Adds an option of this name that takes formats, with commas between them. */
CLI::Option* add_formats(
    CLI::App& app, const std::string& name, ExportOptions& options, const std::string& help);

}  // namespace talus::app
