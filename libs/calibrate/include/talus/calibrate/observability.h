#pragma once
#include <talus/calibrate/information.h>

namespace talus::calibrate
{
/** Which of the wanted parameters the log constrains. The weakest direction is sought until none is
 * weak: one along which the answer would be no better than useful_sigma, or would come from noise
 * in the planes. Of the parameters that share it the one is given up that a tape measures best: x
 * and y before yaw, yaw before the clock, roll and pitch last. */
Choice observable(const Information& info, const Choice& wanted);

}  // namespace talus::calibrate
