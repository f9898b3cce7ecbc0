#pragma once
#include "../common/run_app.h"
#include "job.h"
#include "settings.h"

#include <string>

namespace talus::app
{
/** Maps one log in a child process, so that a crash over a corrupt file costs one log, and lets the
 * results appear when all of them are written. `label` goes before the progress bar. True when
 * done; else the reason has been printed. */
bool run_job(
    const Job& job, const Options& options, const Settings& settings, const std::string& label);

/** Reads one log, likewise, and prints a configuration that suits it. */
bool suggest_settings(const Job& job, const Options& options, const Settings& settings);

/** Checks, in a child process, that the map can be made with these settings. False when not: the
 * reason has been printed. */
bool settings_work(const Settings& settings);

/** How many devices the CUDA backend has; asked in a child process, as CUDA does not survive
 * fork(). */
int count_devices();

}  // namespace talus::app
