#pragma once
#include <mrpt/poses/CPose3D.h>
#include <talus/io/trajectory.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace talus::import
{
/** One scan of one sensor, as a file of another program holds it. */
struct ImportedScan
{
  std::string sensor_label;  //!< ROS topic or folder name; one a sensor
  double time_s = 0;  //!< seconds since the epoch
  mrpt::poses::CPose3D T_base_sensor;  //!< the mounting
  /** In the frame of the sensor [m]; finite. */
  std::vector<float> x_m, y_m, z_m;
  /** Where x_m, y_m and z_m count from [m]: 0, but for points in world coordinates, which are more
   * than a float can hold. Those that open_scan_source() gives are always 0. */
  std::array<double, 3> origin_m{};
  /** The pose of the sensor, where its source has one for each scan; else its poses() count. */
  std::optional<mrpt::poses::CPose3D> T_map_sensor;
  std::vector<float> intensity;  //!< as the file has it, or the values of SourceOptions::values;
                                 //!< empty, or one a point
  std::vector<std::uint32_t> rgb;  //!< 0x00RRGGBB; empty, or one a point
  std::vector<float> point_time_s;  //!< relative to time_s; empty, or one a point
  std::vector<std::uint16_t> ring;  //!< the beam; empty, or one a point
  std::size_t not_finite = 0;  //!< points that were left out
};

struct SourceOptions;

/** What the scans of a source are. */
enum class Pieces
{
  Scans,  //!< of a sensor
  Viewpoints,  //!< the points of a map, by where they were seen from
  Tiles  //!< the points of a map, cut into tiles; neither rays nor poses tell anything
};

/** Scans in the order of time [of one sensor], one at a time: a source holds one in memory. */
class ScanSource
{
 public:
  virtual ~ScanSource() = default;

  /** False at the end; `scan` is then left as it is. Throws std::runtime_error that names the file,
   * the place (byte, line or message) and what is wrong. */
  virtual bool next(ImportedScan& scan) = 0;

  /** Fraction read so far, 0..1. */
  virtual double progress() const = 0;

  /** Poses of the base in the map frame that the source itself has; complete once next() gave
   * false. Empty when it has none. Those that lie beside the scans are there from the beginning. */
  virtual io::Trajectory poses() = 0;

  /** What a person should know of how it was read, a sentence each without its full stop; complete
   * once next() gave false. */
  virtual std::vector<std::string> remarks() const { return {}; }
  /** What would make the map wrong; otherwise as remarks(). */
  virtual std::vector<std::string> warnings() const { return {}; }

  /** What its scans are. */
  virtual Pieces pieces() const { return Pieces::Scans; }

  /** Whether the map would be wrong, but would not if all were read again with other options: sets
   * these. Complete once next() gave false. */
  virtual bool wants(SourceOptions& options) const
  {
    (void)options;
    return false;
  }
};

/** What only some kinds of source ask for; each names its option in its errors. */
struct SourceOptions
{
  std::string poses;  //!< --poses FILE: TUM, KITTI (12 or 13 numbers a line) or .simplemap; "":
                      //!< those of the source
  bool own_poses = true;  //!< false: a folder need not look for poses, another source has them
  std::vector<std::string> topics;  //!< --topic NAME, of bags; empty: all with PointCloud2
  std::string base_frame;  //!< --base-frame NAME, of TF; "": base_link, base_footprint or the child
                           //!< of odometry
  std::string map_frame;  //!< --map-frame NAME, of TF; "": map, else odom
  bool recorded_times = false;  //!< --recorded-times, of bags: scans have the time of recording,
                                //!< not the stamp of their sensor
  bool stamped_times = false;  //!< --stamped-times: they have the stamps, whatever these are
  std::vector<std::string> recorded_topics;  //!< whose scans alone have the time of recording
  bool partial = false;  //!< --partial: of bags that are cut what is before the cut, of folders
                         //!< with fewer poses than scans as many of the first scans
  bool poses_of_sensor = false;  //!< --poses-of sensor: of the first one, not of the base
  bool clouds_in_map = false;  //!< --clouds-in map: points lie in the frame of the poses
  bool is_one_scan = false;  //!< --clouds-in sensor was said: a file is no map of a whole drive
  bool is_only_source = true;  //!< false: there are others, which have to agree on one map
  std::vector<std::string> fields;  //!< --fields: of a point in .bin files; empty: KITTI's four
  std::string values;  //!< --values, of each point: "": its intensity; "rgb"; else a field by its
                       //!< name; "label" and "semantickitti": also of .label files beside .bin
  double scale = 1;  //!< --scale: metres of one unit of x, y and z
  double rate_hz = 10;  //!< --rate, of folders without times
  /** --mount, by label: T_base_sensor; "" where there is one sensor. */
  std::map<std::string, mrpt::poses::CPose3D> mountings;
  /** nullptr: it was not given. */
  const mrpt::poses::CPose3D* mounting_of(const std::string& label) const
  {
    auto found = mountings.find(label);
    if (found == mountings.end()) found = mountings.find("");
    return found == mountings.end() ? nullptr : &found->second;
  }
};

struct Format;

/** By the ending alone; null: none that is known. */
const Format* format_by_ending(const std::string& path);

/** What is read as one: a file, a folder of scans, or ROS 2 bags. */
struct Input
{
  /** Looks at its first bytes, or at its ending where these do not show it, or into the folder.
   * Opens regular files only. */
  explicit Input(const std::string& path);

  /** Of ROS 2: a folder, or .db3 and .mcap. */
  bool is_bag() const;

  std::vector<std::string> paths;  //!< several of bags only
  const Format* format = nullptr;  //!< null: a folder that is no bag, or nothing that is known
};

/** Bags that are given together become one, as the parts of one are: the links of TF in one are of
 * use to all. */
std::vector<Input> inputs_of(const std::vector<std::string>& paths);

/** Throws std::runtime_error that names the file, what is wrong and what to do, also for what no
 * source reads, and where this build lacks what reads it. */
std::unique_ptr<ScanSource> open_scan_source(const Input& input, const SourceOptions& options);

}  // namespace talus::import
