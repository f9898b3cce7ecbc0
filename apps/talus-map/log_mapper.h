#pragma once
#include "../common/import/rawlog_writer.h"
#include "job.h"
#include "kept_site.h"
#include "label_files.h"
#include "pose_source.h"

#include <talus/elevation_mapper.h>
#include <talus/frame_gatherer.h>
#include <talus/hints/hint_finder.h>
#include <talus/io/layer_stack.h>
#include <talus/io/summary_json.h>
#include <talus/mrpt/observation_points.h>

#include <mrpt/obs/CObservation.h>
#include <opencv2/core.hpp>
#include <talus/io/geo_origin.h>

#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace talus::app
{
/** Feeds the scans of one log to a map and keeps count. */
class LogMapper
{
 public:
  /** Called after every frame that reached the map. */
  using OnFrame = std::function<void(const LogMapper&, double progress)>;

  /** `log` is what is read for the job. `site` keeps what leaves the window; null: nothing does.
   * `labels` gets what each point is; null: nobody does. Throws what ElevationMapper throws. */
  LogMapper(
      const Job& job, const SourceLog& log, const Options& options, const Settings& settings,
      KeptSite* site = nullptr, LabelFiles* labels = nullptr);

  /** Reads the log to its end. Throws std::runtime_error when it cannot be read, has no poses, or
   * no scan of it is usable: the message says why and what to do. */
  void run(const OnFrame& on_frame);

  const ElevationMapper& map() const { return map_; }
  /** All layers of the map as it is, with the optional ones that were asked for. */
  io::LayerStack layers() const;
  const mrpt::poses::CPose3D& last_base() const { return last_T_map_base_; }
  /** The last part of the way of the base, map frame [m], for pictures. */
  const std::deque<cv::Point2d>& last_way() const { return last_way_; }
  /** How long all of it is. */
  double driven_m() const { return driven_m_; }
  /// @name Of the scan, or the part of one, that was read last
  /// @{
  const mrpt::poses::CPose3D& last_sensor() const { return scan_.T_base_sensor; }
  mrpt::system::TTimeStamp last_stamp() const { return last_stamp_; }
  const std::string& last_label() const { return last_label_; }
  /// @}
  const io::RunSummary& summary() const { return run_; }
  /** What the log says of its points. */
  const import::PointNotes& notes() const { return notes_; }
  /** Parameters that suit the log, once it was read. */
  std::vector<hints::Suggestion> suggest() const { return hints_.suggest(); }
  io::RunSummary& summary() { return run_; }

 private:
  /** What two scans share only if they are the same one. */
  struct LastScan
  {
    double stamp_s;
    std::size_t points;
    std::uint64_t hash;  //!< of the points
    mrpt::poses::CPose3D T_base_sensor;
    bool operator==(const LastScan& o) const
    {
      return stamp_s == o.stamp_s && points == o.points && hash == o.hash &&
             T_base_sensor == o.T_base_sensor;
    }
  };

  bool take(const mrpt::obs::CObservation& obs);
  void note_points(const std::string& description);
  void scale_intensity(const mrpt::obs::CObservation& obs);
  bool decode(const mrpt::obs::CObservation& obs);
  bool insert(const std::string& label);
  bool skip(const std::string& reason, const std::string& why);
  void note_way();
  bool note_stamp(const mrpt::obs::CObservation& obs);
  [[noreturn]] void explain_no_frames() const;
  void require_points() const;
  void check_channels(const Frame& frame);
  void require_channels_of_log() const;
  void map_scan(const Frame& scan);
  FrameReport map_frame(const Frame& frame);
  void add_warnings();
  void add_hints();
  bool has_rays() const { return notes_.pieces != import::Pieces::Tiles; }

  const Job& job_;
  const Options& options_;
  const Settings& settings_;
  std::string log_;  //!< as messages call it
  const SourceLog& source_;
  PoseSource poses_;
  ElevationMapper map_;
  KeptSite* site_;
  LabelFiles* labels_;
  io::RunSummary run_;
  SensorPoints scan_;
  import::PointNotes notes_;
  std::vector<bool> has_channel_;  //!< by channel: some scan has values of it
  SensorNumbers sensors_;
  FrameGatherer gatherer_;
  hints::HintFinder hints_;
  mrpt::poses::CPose3D last_T_map_base_;
  std::deque<cv::Point2d> last_way_;
  double driven_m_ = 0;
  mrpt::system::TTimeStamp last_stamp_;
  std::string last_label_;
  std::map<std::string, LastScan> last_scans_;  //!< by sensor label
  std::map<std::string, std::string> first_skip_;  //!< what was wrong first, by reason
  std::set<std::string> other_labels_;  //!< of sensors that were not asked for
  double first_stamp_s_ = HUGE_VAL, final_stamp_s_ = -HUGE_VAL;  //!< of all scans
};

/** Writes map.tif, map.png, timing.csv and summary.json into a folder. Throws std::runtime_error
 * naming the file. */
void write_results(
    const std::string& folder, const LogMapper& mapper, const std::optional<io::GeoOrigin>& origin);

/** Writes frames/frame_NNNNNN.tif and .png of the map as it is now. Throws std::runtime_error. */
void write_snapshot(
    const std::string& folder, const LogMapper& mapper, const std::optional<io::GeoOrigin>& origin);

/** A few lines for the terminal about what was done. */
std::string console_summary(const LogMapper& mapper);

/** The text of an INI file (--config) that suits the log that was read, a line a parameter, each
 * with its reason. */
std::string suggestion_ini(const LogMapper& mapper);

}  // namespace talus::app
