#pragma once
#include <mrpt/poses/CPose3D.h>
#include <talus/frame.h>

namespace talus
{
/** The same rigid transform without MRPT. */
Pose pose_from(const mrpt::poses::CPose3D& pose);

}  // namespace talus
