#pragma once
#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/img/color_maps.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/math/TBoundingBox.h>
#include <mrpt/poses/CPose3D.h>
#include <talus/elevation_mapper.h>
#include <talus/map_view.h>
#include <talus/mrpt/nearest_points.h>
#include <talus/mrpt/observation_points.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/version_compat.h>
#include <talus/point_labels.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace talus
{
class WholeMap;
namespace hints
{
class HintFinder;
}

/** Robot-centric terrain map: two persistent surfaces, the elevation and the ground, with gaps in
 * the ground filled and each cell judged for driving (Xie et al., see doc/concepts.md). A thin MRPT
 * face of talus::ElevationMapper.
 *
 * Accepts the observations of points_from_observation(): mrpt::obs::CObservationPointCloud,
 * CObservationVelodyneScan, CObservationRotatingScan, CObservation3DRangeScan and
 * CObservation2DRangeScan, of one sensor or several, told apart by their labels. Points are placed
 * at `robotPose (+) sensorPose`, the window around `robotPose`; any other class is refused
 * (insertObservation() returns false), and nothing throws. All heights are in the map frame. A 2D
 * scanner must be tilted: a level scan shows no terrain, and what it hits, walls too, counts as
 * ground that is flat and free (told once on stderr).
 *
 * With `keep_whole` it keeps what leaves its window, gives it back where the robot returns, and all
 * queries are about the whole floor on which the robot is, however far away (of a floor that is
 * wider than 4096 cells, about so many around the robot); see doc/site.md.
 *
 * What looks wrongly set (mounting, poses, height band, the robot's own body ...) is told once on
 * stderr, as soon as it is certain; see doc/hints.md.
 *
 * Inside a CMultiMetricMap its name is `terrain`: `terrain_count = 1`, sections
 * `[<name>_terrain_00_creationOpts]` (resolution, window, backend, threads, device, keep_whole),
 * `_insertOpts`, `_likelihoodOpts`, `_renderOpts`. Not thread safe. An empty map costs nothing to
 * copy.
 *
 * Read from a stream that is damaged or made up, it throws and stays as it was; the memory that
 * this takes grows with the bytes that are there, whatever they say. Options that are out of range
 * are refused by name: when written or read, and where they are used. */
class CDualElevationMap : public mrpt::maps::CMetricMap, public NearestPoints, public OptionsCapable
{
  DEFINE_SERIALIZABLE(CDualElevationMap, talus)

 public:
  /** Arguments and exceptions as of ElevationMapper; a missing device shows at the first use. */
  explicit CDualElevationMap(
      const Parameters& parameters = {}, Backend backend = Backend::Auto, int threads = kAllCores,
      bool keep_whole = false, int device = 0);
  /** A copy has its own cells; it goes on with the same bits. */
  CDualElevationMap(const CDualElevationMap& o);
  /** As the constructor. */
  CDualElevationMap& operator=(const CDualElevationMap& o);
  ~CDualElevationMap() override;

  /** @name The pipeline behind the map. Layers are made when somebody reads them; name those that
   * are read after every observation with mapper().set_output_layers().
   *  @{ */
  /** Made with the first call or observation. Throws as its constructor. */
  ElevationMapper& mapper();
  /** The same. */
  const ElevationMapper& mapper() const;
  /** Of the last accepted observation. */
  const FrameReport& lastReport() const { return m_lastReport; }
  /** As asked for; mapper().backend_name() says which runs. */
  Backend backend() const { return m_backend; }
  /** As asked for. */
  int threads() const { return m_threads; }
  /** As asked for. */
  int device() const { return m_device; }
  /** @} */

  /** A label for each point of an observation, in the order of points_from_observation(), by the
   * window as it is, see label_points(); the robot was at `robotPose`. So insert it before. Empty
   * for a class that holds no points that this map understands. Throws std::runtime_error where the
   * observation cannot be decoded, and as label_points(). labelled_cloud() puts them into a cloud.
   */
  std::vector<PointLabel> labelPoints(
      const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& robotPose = {}) const;

  /** @name All that was seen
   *  @{ */
  /** Whether what leaves the window is kept. */
  bool keepsWhole() const { return m_keep_whole; }
  /** What queries are about: the window, or the whole floor. Valid until the map changes. */
  MapView view() const;
  /** Goes on with what saveMetricMapRepresentationToFile() wrote as PREFIX_site.tif, or talus-map
   * as site.tif: to be called before the first observation. Other floors are read from the files
   * beside it. Throws std::logic_error for a map that does not keep the whole or is not empty, and
   * std::runtime_error naming the file. */
  void loadSite(const std::string& path);
  /** @} */

  /** @name Virtual methods of CMetricMap
   *  @{ */
  /** True until the first observation was inserted. */
  bool isEmpty() const override;
  /** A line for people: size, place, how much is known. */
  std::string asString() const override;
  /** Both surfaces as triangles named "ground" and "elevation", see TRenderOptions. Made once for
   * each state of the map: scenes share the triangles. Throws std::invalid_argument for a
   * renderOptions that is out of range. */
  void getVisualizationInto(mrpt_scene::CSetOfObjects& outObj) const override;
  /** Writes PREFIX.tif (all layers of the window, GeoTIFF), PREFIX.png (picture) and
   * PREFIX.3Dscene; where the whole is kept also PREFIX_site.tif and PREFIX_site.png, and of other
   * floors PREFIX_site_floor_1.tif and so on; nothing for an empty map. Throws std::runtime_error
   * naming the file. */
  void saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const override;
  /** Fraction [0,1] of the other map's points (getAsSimplePointsMap()) within `maxDistForCorr` [m]
   * of a surface of their cell, the distance d of TLikelihoodOptions. 0 when there are none. */
  float compute3DMatchingRatio(
      const mrpt::maps::CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
      const mrpt::maps::TMatchingRatioParams& params) const override;
  /** A point at the top of each cell on which something stands, higher than a cell's side, map
   * frame. Valid until the map changes. */
  const mrpt::maps::CSimplePointsMap& standingPoints() const;
  /** Pairs of points with standingPoints(), seen from above: the ground itself is everywhere. */
  void determineMatching2D(
      const mrpt::maps::CMetricMap* otherMap, const mrpt::poses::CPose2D& otherMapPose,
      mrpt::tfest::TMatchingPairList& correspondences, const mrpt::maps::TMatchingParams& params,
      mrpt::maps::TMatchingExtraResults& extraResults) const override;
  /** The square of the distance [m^2] of a place of the map frame to the nearest of
   * standingPoints(), seen from above; infinite where there is none. */
  float squareDistanceToClosestCorrespondence(float x0, float y0) const override;
  /** Pairs of points with getAsSimplePointsMap(). */
  void determineMatching3D(
      const mrpt::maps::CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
      mrpt::tfest::TMatchingPairList& correspondences, const mrpt::maps::TMatchingParams& params,
      mrpt::maps::TMatchingExtraResults& extraResults) const override;
  /** What was measured (no filled cell) as points at the cell centres, map frame: one on the
   * elevation, another on the ground where it lies more than a cell's side below. Owned by this
   * map, valid until it changes. */
  const mrpt::maps::CSimplePointsMap* getAsSimplePointsMap() const override;
  /** Of both surfaces, map frame [m]; all zeros for an empty map. */
  mrpt::math::TBoundingBoxf boundingBox() const TALUS_OVERRIDE_SINCE_2_11_3;
  /** costmap_from_map() of this map, the robot where the last observation had it. */
  void getAsOccupancyGrid(
      mrpt::maps::COccupancyGridMap2D& out, const ObstacleOptions& options = {}) const;
  /** @} */

  /** Every parameter of the pipeline, see doc/parameters.md. A change counts from the next
   * insertion on; a new resolution_m or window_m starts an empty map. */
  struct TInsertionOptions : public mrpt::config::CLoadableOptions, public Parameters
  {
    /** Reads those keys that are there. Throws std::runtime_error naming key, value and section. */
    void loadFromConfigFile(
        const mrpt::config::CConfigFileBase& source, const std::string& section) override;
    /** Writes each with its meaning as comment. */
    void saveToConfigFile(
        mrpt::config::CConfigFileBase& target, const std::string& section) const override;
    /** A line each. */
    void dumpToTextStream(std::ostream& out) const override;
  };
  /** What the next observation is inserted with. */
  TInsertionOptions insertionOptions;

  /** The log-likelihood of an observation is the sum, over every `decimation`-th accepted point, of
   *     log( outlierRatio + (1 - outlierRatio) * exp( -d^2 / (2 (sigma_m^2 + variance)) ) )
   * where d [m] is the vertical distance of the point, placed in the map, to what a sensor can see
   * in its cell: the ground, the elevation, and (d = 0) the side of an object between both where a
   * neighbour is lower. `variance` is the cell's. A point over an unknown cell or outside of the
   * window is an outlier. 0 for an empty map. */
  struct TLikelihoodOptions : public mrpt::config::CLoadableOptions
  {
    /** Reads those keys that are there. Throws std::runtime_error naming key, value and section. */
    void loadFromConfigFile(
        const mrpt::config::CConfigFileBase& source, const std::string& section) override;
    /** Writes each with its meaning as comment. */
    void saveToConfigFile(
        mrpt::config::CConfigFileBase& target, const std::string& section) const override;
    /** Throws std::invalid_argument that names the first value out of its range. */
    void validate() const;
    double sigma_m{0.05};  //!< standard deviation of a point, (0, 10] m
    double outlierRatio{0.1};  //!< (0, 1)
    int decimation{10};  //!< takes one point of this many, 1 to 1000000
  };
  /** Of observation likelihoods. */
  TLikelihoodOptions likelihoodOptions;

  /** How getVisualizationInto() draws the map. */
  struct TRenderOptions : public mrpt::config::CLoadableOptions
  {
    /** Reads those keys that are there. Throws std::runtime_error naming key, value and section. */
    void loadFromConfigFile(
        const mrpt::config::CConfigFileBase& source, const std::string& section) override;
    /** Writes each with its meaning as comment. */
    void saveToConfigFile(
        mrpt::config::CConfigFileBase& target, const std::string& section) const override;
    /** Throws std::invalid_argument that names the first value out of its range. */
    void validate() const;
    /** Draw the ground, with a hole where nothing is known. */
    bool showGround{true};
    bool showElevation{true};  //!< with the ground shown: only where it stands above the ground
    bool colorByTraversability{true};  //!< io::score_colour(); false: by height
    mrpt::img::TColormap colormap{mrpt::img::cmJET};  //!< of heights
    int maxCells{
        512};  //!< along a side, 2 to 1000000; larger windows are drawn with every n-th cell
  };
  /** Of getVisualizationInto(). */
  TRenderOptions renderOptions;
  /** The three by their names, for programs of MRPT that know no class. */
  std::map<std::string, mrpt::config::CLoadableOptions*> optionsByName() override
  {
    return {
        {"insertionOptions", &insertionOptions},
        {"likelihoodOptions", &likelihoodOptions},
        {"renderOptions", &renderOptions}};
  }

  MAP_DEFINITION_START(CDualElevationMap)
  std::optional<double> resolution;  //!< side of a cell [m]; set: goes before insertionOpts
  std::optional<double> window;  //!< side of the window [m]; set: goes before insertionOpts
  /** Where it runs. */
  Backend backend{Backend::Auto};
  /** Of the CPU backend. */
  int threads{kAllCores};
  int device{0};  //!< of the CUDA backend
  /** All that was seen is kept, not the window alone. */
  bool keepWhole{false};
  std::string place;  //!< where a file has the backend, to end messages with; empty: made in code
  /** As insertionOptions. */
  talus::CDualElevationMap::TInsertionOptions insertionOpts;
  /** As likelihoodOptions. */
  talus::CDualElevationMap::TLikelihoodOptions likelihoodOpts;
  /** As renderOptions. */
  talus::CDualElevationMap::TRenderOptions renderOpts;
  MAP_DEFINITION_END(CDualElevationMap)

 protected:
  // What CMetricMap calls of clear(), insertObservation() and the likelihoods.
  /// @cond
  void internal_clear() override;
  bool internal_insertObservation(
      const mrpt::obs::CObservation& obs,
      const std::optional<const mrpt::poses::CPose3D>& robotPose = std::nullopt) override;
  double internal_computeObservationLikelihood(
      const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& takenFrom) const override;
  bool internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& obs) const override;
#if MRPT_VERSION >= 0x020b03
  const mrpt::maps::CSimplePointsMap& nn_points() const override { return *getAsSimplePointsMap(); }
#endif
  /// @endcond

 private:
  void takeSettings(const CDualElevationMap& o);
  void applyOptions();
  void forgetDerived();
  void drawScene() const;
  void readVersion0(mrpt::serialization::CArchive& archive);
  void insertPoints(const SensorPoints& points, const mrpt::poses::CPose3D& T_map_base);
  void watch(const Frame& frame, const std::string& sensor);
  WholeMap& whole() const;

  Backend m_backend = Backend::Auto;
  int m_threads = kAllCores;
  int m_device = 0;  //!< of this machine: not written into streams
  bool m_keep_whole = false;
  mutable std::unique_ptr<ElevationMapper> m_mapper;  //!< made on first use
  mutable std::unique_ptr<WholeMap> m_whole;  //!< the same, where it is kept
  mutable mrpt::maps::CSimplePointsMap::Ptr m_pointsCache;  //!< of getAsSimplePointsMap()
  mutable mrpt::maps::CSimplePointsMap::Ptr m_standingCache;  //!< of standingPoints()
  mutable std::vector<std::shared_ptr<MrptSceneObject>> m_sceneCache;  //!< of the map as it is,
  mutable TRenderOptions m_sceneOptions;  //!< drawn with these options
  mrpt::poses::CPose3D m_T_map_base;  //!< of the last insertion
  SensorNumbers m_sensors;  //!< of the labels of the observations
  FrameReport m_lastReport;
  std::unique_ptr<hints::HintFinder> m_hints;  //!< made with the first observation
  bool m_hintsDone = false;
  SensorPoints m_scratch;  //!< reused: no allocation per observation once warm
};

/** Makes the MRPT classes of this library known by name, for INI files and serialization. Programs
 * that link the library call it once at start: it also makes their copy of the classes the one that
 * counts when the plugin has been preloaded. Calling it again does no harm. */
void register_mrpt_classes();

/** The points of an observation in the frame of their sensor, as a cloud with the number of each
 * one's label as its intensity: the one field of a point that clouds of all versions of MRPT write
 * into logs. Throws std::invalid_argument unless there is a label for each point. */
mrpt::maps::CPointsMap::Ptr labelled_cloud(
    const SensorPoints& points, const std::vector<PointLabel>& labels);

}  // namespace talus
