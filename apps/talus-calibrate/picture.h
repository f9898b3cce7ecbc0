#pragma once
#include <talus/calibrate/calibrate.h>

#include <string>

namespace talus::calibrate
{
/** Before and after: thickness of the ground and how high or low it is seen, by range, of the
 * held-out frames. Writes a PNG; throws std::runtime_error naming the file. */
void write_picture(const std::string& path, const std::string& title, const Result& result);

}  // namespace talus::calibrate
