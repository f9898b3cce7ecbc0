#pragma once

namespace talus::test
{
/** Whether this processor runs what this executable was compiled for. */
bool can_run();
}  // namespace talus::test
