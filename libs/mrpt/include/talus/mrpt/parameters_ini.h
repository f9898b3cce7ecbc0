#pragma once
#include <mrpt/config/CConfigFileBase.h>
#include <talus/elevation_mapper.h>
#include <talus/parameters.h>

#include <string>
#include <vector>

namespace talus
{
/** Reads `[<section_prefix>_creationOpts]`, then `[<section_prefix>_insertOpts]`; every parameter
 * is accepted in either, `resolution` and `window` stand for `resolution_m` and `window_m`. What no
 * section names keeps its value.
 *
 * Returns warnings for a person: unknown keys (with key, section and the nearest known name),
 * sections of this prefix that nothing reads. Throws std::runtime_error that names key, value, what
 * is allowed, section and file, and what require_sound_ini() throws; `p` is then unchanged. */
std::vector<std::string> load_parameters(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section_prefix, Parameters& p);

/** The same for one section, without validating combinations of parameters. */
void load_parameter_section(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, Parameters& p,
    std::vector<std::string>& warnings);

/** Throws std::runtime_error "FILE:LINE: what is wrong; what to do" where MRPT would drop something
 * of these sections without a word: a line without `=`, a key that is given twice, a comment that
 * swallows the next line, a section name without its bracket or with something behind it; and for
 * a NUL byte anywhere, where MRPT stops reading. `text` is what the file holds. */
void require_sound_ini(
    const std::string& text, const std::string& file, const std::vector<std::string>& sections);

/** The same for the file that a mrpt::config::CConfigFile has read; of any other configuration the
 * text is not known, and nothing is checked. Whatever reads a section here calls it. */
void require_sound_ini(
    const mrpt::config::CConfigFileBase& cfg, const std::vector<std::string>& sections);

/** The name of the parameter that a key stands for: `resolution_m` for `resolution`, `window_m` for
 * `window`, else the key itself, in lower case. */
std::string parameter_of_key(const std::string& key);

/** Reads the keys `backend` (auto, cpu, cuda), `threads` (of the CPU backend, 0: all cores) and
 * `device` (of the CUDA backend, from 0) of `[<section_prefix>_creationOpts]`; a key that is absent
 * leaves its argument alone. Throws as load_parameters(). */
void load_execution(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section_prefix, Backend& backend,
    int& threads, int& device);

/** Writes every parameter with unit and meaning as comment; load_parameter_section() reads them
 * back. */
void save_parameters(
    mrpt::config::CConfigFileBase& cfg, const std::string& section, const Parameters& p);

/** Warnings for the keys of a section that are not in `known` (case ignored). */
void warn_unknown_keys(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section,
    const std::vector<std::string>& known, std::vector<std::string>& warnings);

/** A value without its trailing comment (`;`, `#` or `//`) and without blanks around it. */
std::string ini_value(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key);

/** "auto", "cpu" or "cuda", and back; std::invalid_argument for any other text. */
std::string backend_text(Backend backend);
Backend backend_from_text(const std::string& text);

/** The table of all parameters in Markdown, that of doc/parameters.md: name, default, unit, range,
 * meaning. */
std::string parameters_as_markdown();

/** Gives [CHolonomicFullEval] of a file for MRPT's reactive planners as many factors as this MRPT
 * weighs, which refuses any other number: 7 up to 2.14.2, 8 from 2.14.3 on. The eighth, the heading
 * at the goal, is left out or gets weight 0. */
void fit_planner_ini(mrpt::config::CConfigFileBase& ini);

}  // namespace talus
