#pragma once
#include "load_log.h"

#include <string>

namespace talus::calibrate
{
/** What is printed when all is done: the parameters, the noise, what the held-out frames say. */
std::string console_report(const AppOptions& options, const LoadedLog& log, const Result& result);

}  // namespace talus::calibrate
