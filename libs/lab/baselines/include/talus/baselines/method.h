#pragma once
#include <talus/elevation_mapper.h>
#include <talus/sim/drive.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/** What talus is compared with: other methods from scans to ground, obstacles and passable cells,
 * and other methods to fill gaps. */
namespace talus::baselines
{
/** What a map says about each cell of a window; index = iy * window.cells + ix, NaN: unknown. */
struct Surfaces
{
  Window window;
  std::vector<float> elevation_m;  //!< top of what stands on the ground, or the ground; map frame
  std::vector<float> ground_m;  //!< map frame
  std::vector<float> traversability;  //!< [0,1], 0: blocked
  std::vector<float>
      sparsity;  //!< [0,1], 0: likely a ditch; empty for methods without such a layer
  std::vector<float> variance_m2;  //!< estimate of ground_m; empty for methods without
  std::vector<float> risk;  //!< see Method::risk(); empty where it was not asked
  std::vector<std::uint8_t> state;  //!< a CellState: where ground_m comes from

  /** All cells of `window` unknown. */
  explicit Surfaces(const Window& window);
  Surfaces() = default;

  std::size_t size() const { return ground_m.size(); }
  bool known(std::size_t i) const { return ground_m[i] == ground_m[i]; }
  bool blocked(std::size_t i) const { return traversability[i] == 0.0f; }
  /** Known to be free; unknown is neither free nor blocked. */
  bool passable(std::size_t i) const { return traversability[i] > 0.0f; }
};

/** One method to map. All get the same frames and the same parameters: window, resolution, range
 * and height band, thresholds. */
class Method
{
 public:
  virtual ~Method() = default;
  /** Takes in one frame. */
  virtual void update(const Frame& frame) = 0;
  /** The map around the sensor of the last frame, judged: the window that talus would show. What a
   * method computes on demand only (columns, features) is computed here. */
  virtual Surfaces read() = 0;
  /** The risk of the cells of read(), see talus::risk(); empty for methods without. */
  virtual std::vector<float> risk() { return {}; }
};

/** Names that make_method() takes, with a sentence each. */
struct MethodInfo
{
  const char* name;
  const char* description;
  std::unique_ptr<Method> (*make)(const Parameters&, Backend);
};
const std::vector<MethodInfo>& method_list();

/** Throws std::invalid_argument naming the known ones. `backend`: of talus. */
std::unique_ptr<Method> make_method(
    const std::string& name, const Parameters& parameters, Backend backend = Backend::Cpu);

/** The window that talus shows around the base of a robot. */
Window window_around(const Parameters& parameters, const Pose& T_map_base);

/** A point in the map frame [m] and its range from the sensor [m]. */
struct MapPoint
{
  float x_m, y_m, z_m, range_m;
};
/** The points of a frame that pass range, height band and body boxes (stage 1 of talus), map frame;
 * those outside the window too. */
std::vector<MapPoint> accepted_points(const Frame& frame, const Parameters& parameters);

/** The lowest of the points in each cell of a window [m]; NaN: none. */
std::vector<float> lowest_points(const std::vector<MapPoint>& points, const Window& window);

/** Index of the cell at (x, y), or -1 outside. */
int cell_index(const Window& window, double x_m, double y_m);
struct Middle
{
  double x_m, y_m;
};
/** Of the cell with an index. */
Middle middle_of_cell(const Window& window, std::size_t k);

/** One scan with its pose. */
struct ScanFrame
{
  double stamp_s = 0;  //!< since the epoch
  double time_s = 0;  //!< since the first frame
  Pose T_map_sensor;  //!< as the maps get it
  std::optional<Pose> T_base_sensor;  //!< where the sensor is on the robot, if that is known
  std::uint32_t sensor = 0;  //!< which of several
  std::size_t scan = 0;  //!< its number among the scans of its log, also those without a pose
  Pose T_true;  //!< where the sensor really was; the same where nobody knows better
  std::vector<float> x_m, y_m, z_m;  //!< sensor frame

  Frame view() const;
};

/** All scans of a log or of a simulated drive. */
struct Sequence
{
  std::string name;
  std::vector<ScanFrame> frames;
  std::string sensor{};  //!< what took the scans: the scanners of a world, the labels of a log
};

/** Names a sensor of the sequence, once. */
void add_sensor(Sequence& sequence, const std::string& name);

/** Scans a world. The poses have the errors of the drive's options. */
Sequence simulate(
    const sim::World& world, const sim::Drive& drive,
    const std::function<void(int done, int total)>& progress = {});

}  // namespace talus::baselines
