#pragma once
#include <array>
#include <string>

namespace talus::app
{
/** Where a sensor is mounted, as CPose3D counts: x, y, z [m], yaw, pitch, roll [degrees]. */
using Mounting = std::array<double, 6>;

/** How --help names such a value, which all commands take alike. */
constexpr const char* kMountingForm = "X,Y,Z,YAW,PITCH,ROLL";

/** Reads six numbers with commas between them; throws std::invalid_argument, which says what is
 * wrong. */
Mounting mounting_from_text(const std::string& text);

/** The text that mounting_from_text() reads: to 0.1 mm and 0.001 degrees. */
std::string text_of_mounting(const Mounting& mounting);

}  // namespace talus::app
