#pragma once
#include <mrpt/config/CConfigFileBase.h>

#include <string>
#include <vector>

namespace talus::detail
{
/** Endings of the sections of one map. */
const std::vector<std::string>& section_endings();

/** The file that a configuration was read from; empty where it is none. */
std::string file_of(const mrpt::config::CConfigFileBase& cfg);

/** " (in section NAME of FILE)", to end what is wrong with it; the file where it is known. Without
 * square brackets: what MRPT prints of an exception ends at the first pair of them. */
std::string in_section(const mrpt::config::CConfigFileBase& cfg, const std::string& section);
/** The same of two of them. */
std::string in_sections(
    const mrpt::config::CConfigFileBase& cfg, const std::string& a, const std::string& b);

/** Where the comment of a line begins (`;`, `#` or `//`), or its length. */
std::size_t comment_begin(const std::string& text);

/** All keys of a section, without the comments with `//` that MRPT takes for keys. */
std::vector<std::string> keys_of(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section);

/** Throws std::runtime_error: the value at a key must be `allowed`. */
[[noreturn]] void refuse_value(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key,
    const std::string& allowed);

/** A value as a number, or `fallback` where there is no such key. NaN, which no check of a range
 * lets through, for any other text: MRPT reads what it can of it. */
double ini_number(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key,
    double fallback);

/** The same of a whole number in a range. Throws as refuse_value() for any other text. */
int ini_whole_number(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key,
    int fallback, int min, int max);

/** The same of true and false. Throws as refuse_value() for any other text. */
bool ini_flag(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key,
    bool fallback);
}  // namespace talus::detail
