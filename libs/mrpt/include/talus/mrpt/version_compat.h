#pragma once
// Every switch between versions of MRPT lives here. Developed against 2.5.8 (Debian bookworm).
// MRPT_VERSION is 0xMmp up to 2.9 and 0xMMmmpp from 2.10 on, so only >= comparisons with the long
// form are safe.
#include <mrpt/version.h>

#if MRPT_VERSION >= 0x020700
#define TALUS_MRPT_SCENE_HEADER <mrpt/opengl/Scene.h>
namespace mrpt::opengl
{
class Scene;
}
namespace talus
{
using MrptScene = mrpt::opengl::Scene;
}
#else
#define TALUS_MRPT_SCENE_HEADER <mrpt/opengl/COpenGLScene.h>
namespace mrpt::opengl
{
class COpenGLScene;
}
namespace talus
{
using MrptScene = mrpt::opengl::COpenGLScene;
}
#endif

// CMetricMap::boundingBox() is virtual from 2.11.3 on.
#if MRPT_VERSION >= 0x020b03
#define TALUS_OVERRIDE_SINCE_2_11_3 override
#else
#define TALUS_OVERRIDE_SINCE_2_11_3
#endif
