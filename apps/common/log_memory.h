#pragma once
#include <cstddef>
#include <string>

namespace talus::app
{
/** How much memory reading a log or a trajectory may take [bytes]: what its bytes can hold and
 * 100 MB, 2 GB at most. A count in it that is damaged asks for anything. The 100 MB and the 2 GB
 * are shared by the processes that share_log_memory() named. */
std::size_t memory_for_log(const std::string& path);

/** From now on so many processes read logs at once: this one and its children get a part each. */
void share_log_memory(std::size_t processes);

}  // namespace talus::app
