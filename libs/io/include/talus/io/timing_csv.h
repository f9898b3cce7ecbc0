#pragma once
#include <talus/elevation_mapper.h>

#include <string>
#include <vector>

namespace talus::io
{
/** A header line, then one row a frame: `stamp_s` [s since the epoch], `points_in`,
 * `points_accepted`, `rejected_REASON` for each of kRejectNames, `STAGE_ms` for each of
 * kStageNames, `total_ms`. */
std::string timing_csv(const std::vector<FrameReport>& frames);

/** timing_csv() into a file, whole or not at all. Throws std::runtime_error naming the file and the
 * reason. */
void write_timing_csv(const std::string& path, const std::vector<FrameReport>& frames);

}  // namespace talus::io
