#pragma once
#include <mrpt/config/CConfigFileBase.h>

#include <string>

namespace talus::nav
{
/** "CReactiveNavigationSystem" or "CReactiveNavigationSystem3D": the class and its section. */
std::string planner_name(bool in_3d);
/** Where the repository has the file that is built in. */
std::string shipped_ini(bool in_3d);

/** Checks what MRPT takes without a word or refuses without a name: for a number it takes 0 where
 * the text is none. Each value must be of the kind (number, numbers, true or false) that the same
 * key has in the shipped file, numbers within limits; the digits of a key do not count, so that
 * PTG0_K stands for PTG7_K. Keys that the shipped file does not have are left to MRPT, and so are
 * names and formulas. Throws std::runtime_error with key, value, what is allowed and section. */
void check_planner_ini(const mrpt::config::CConfigFileBase& ini, bool in_3d);

}  // namespace talus::nav
