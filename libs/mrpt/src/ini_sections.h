#pragma once
#include <mrpt/config/CConfigFileBase.h>

#include <string>
#include <vector>

namespace talus::detail
{
/** Endings of the sections of one map. */
const std::vector<std::string>& section_endings();

/** " (in section NAME of FILE)", to end what is wrong with it; the file where it is known. Without
 * square brackets: what MRPT prints of an exception ends at the first pair of them. */
std::string in_section(const mrpt::config::CConfigFileBase& cfg, const std::string& section);
/** The same of two of them. */
std::string in_sections(
    const mrpt::config::CConfigFileBase& cfg, const std::string& a, const std::string& b);
}  // namespace talus::detail
