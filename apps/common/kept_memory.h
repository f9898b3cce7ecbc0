#pragma once

namespace talus::app
{
/** From now on memory that was given back is kept for what comes next, in large pages where there
 * are such: a command that makes as much again for each scan would spend a sixth of its time on
 * pages that it had before. It never has more than what it needed at once. */
void keep_memory();

}  // namespace talus::app
