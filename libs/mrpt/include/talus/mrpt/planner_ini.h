#pragma once
#include <mrpt/config/CConfigFileBase.h>

namespace talus
{
/** Gives [CHolonomicFullEval] of a file for MRPT's reactive planners as many factors as this MRPT
 * weighs, which refuses any other number: 7 up to 2.14.2, 8 from 2.14.3 on. The eighth, the heading
 * at the goal, is left out or gets weight 0. */
void fit_planner_ini(mrpt::config::CConfigFileBase& ini);

}  // namespace talus
