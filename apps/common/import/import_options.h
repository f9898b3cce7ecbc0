#pragma once
#include <talus/import/scan_source.h>

namespace CLI
{
class App;
}

namespace talus::import
{
/** What the command line says of how scans of other programs are read. */
struct ImportOptions
{
  SourceOptions source;
};

/** Adds the options of an import (--poses, --mount, --topic ...) to a command, or to a group of its
 * options. */
void add_import_options(CLI::App& app, ImportOptions& options);

}  // namespace talus::import
