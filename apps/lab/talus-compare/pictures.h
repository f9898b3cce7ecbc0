#pragma once
#include <talus/baselines/evaluate.h>

#include <string>
#include <vector>

namespace talus::baselines
{
/** Rows are worlds, columns are the truth and the traversability of each method, as in figure 8 of
 * the paper. Whole or not at all. Throws std::runtime_error. */
void write_maps_picture(const std::string& path, const std::vector<Evaluation>& evaluations);

/** Rows are worlds, columns are the measured ground, the truth and each fill, as in figure 9. */
void write_fills_picture(const std::string& path, const std::vector<Evaluation>& evaluations);

}  // namespace talus::baselines
