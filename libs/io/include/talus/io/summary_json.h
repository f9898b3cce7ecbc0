#pragma once
#include <talus/elevation_mapper.h>
#include <talus/io/layer_stack.h>

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace talus::io
{
/** The whole map of a run: all that its drive saw, and what it went on with. */
struct SiteSummary
{
  double area_m2 = 0;  //!< of the known cells
  double length_m = 0;  //!< of the ways driven
  std::array<std::size_t, kCellStates> cells{};  //!< by CellState; of the unknown ones none
  /** Of which something is known. */
  int floors = 0;
  /** Far from all else of their floor, each in a file of its own. */
  int islands = 0;
};

/** Everything that summary.json says about one run. */
struct RunSummary
{
  std::string version;  //!< of talus
  std::string log;  //!< the rawlog, or what it was made of
  /** How scans of another program were read, a line each; empty for a rawlog. */
  std::vector<std::string> imported;
  std::string backend;  //!< as ElevationMapper::backend_name()
  int threads = 0;  //!< as asked for, 0: all cores
  std::string pose_source;  //!< where the poses came from, in words
  double wall_s = 0;  //!< of the whole run, reading included

  std::vector<FrameReport> frames;  //!< those that reached the map
  std::map<std::string, std::size_t> skipped;  //!< scans that did not, by reason
  std::map<std::string, std::size_t> sensors;  //!< frames by sensor label
  std::map<std::string, std::size_t> unsupported;  //!< other observations, by class name
  std::size_t stamps_backwards = 0;  //!< frames older than the one before of the same sensor
  /** Frames whose points had times, and a path to place them on. */
  std::size_t frames_deskewed = 0;
  /** Written into a rawlog. */
  std::size_t snapshots = 0;
  /** What was odd in the log, a line each. */
  std::vector<std::string> warnings;
  std::vector<std::string> hints;  //!< what looks wrongly set, a line each
  std::optional<SiteSummary> site;  //!< where one was kept

  /** Of the map. */
  Parameters parameters;
};

/** Cells by where their ground height comes from, as fractions of the window (0..1). */
struct Coverage
{
  /** They sum to 1. */
  double measured = 0, filled_two_sided = 0, filled_one_sided = 0, presumed = 0, unknown = 1;
};

/** Counts the layer `state`; all unknown when the stack has none. */
Coverage coverage_of(const LayerStack& stack);

/** Points over all frames. */
struct PointTotals
{
  /** All, and those that reached the map. */
  std::uint64_t in = 0, accepted = 0;
  std::array<std::uint64_t, kRejectCount> rejected{};  //!< indexed by Reject
};

/** Sums of the reports. */
PointTotals totals_of(const std::vector<FrameReport>& frames);

/** The JSON text. `stack` is the map after the last frame. */
std::string summary_json(const RunSummary& run, const LayerStack& stack);

/** summary_json() into a file, whole or not at all. Throws std::runtime_error naming the file and
 * the reason. */
void write_summary_json(const std::string& path, const RunSummary& run, const LayerStack& stack);

/** A header line, then one row a frame: `stamp_s` [s since the epoch], `points_in`,
 * `points_accepted`, `rejected_REASON` for each of kRejectNames, `STAGE_ms` for each of
 * kStageNames, `total_ms`. */
std::string timing_csv(const std::vector<FrameReport>& frames);

/** timing_csv() into a file, whole or not at all. Throws std::runtime_error naming the file and the
 * reason. */
void write_timing_csv(const std::string& path, const std::vector<FrameReport>& frames);

}  // namespace talus::io
