#pragma once
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>
#include <talus/elevation_mapper.h>
#include <talus/mrpt/version_compat.h>

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace talus
{
namespace detail
{
struct PackedLayer;
}

/** A snapshot of the local map at one time, as an observation: logs carry it beside the scans that
 * made it, and stock programs (`rawlog-edit -p libtalus-mrpt.so`) list, cut and export it.
 *
 * Heights are in the map frame, `T_map_base` says where the robot was in it. Layers that were not
 * stored are empty. Not thread safe, not even to read.
 *
 * Serialized, each layer is rounded to 16-bit steps, written as differences along its rows and
 * packed by zlib: heights within 1 mm (where a layer spans over 126 m: within 1/130000 of its
 * span), scores within 0.002 with 0 and 1 exact and nothing else rounded to 0, `state` exact, the
 * variance by its square root within 1 mm. Unknown stays NaN. With the default layers a drive with
 * 160 x 160 cells takes about 60 KB a snapshot instead of 410 KB.
 *
 * What was read stays packed: it takes the memory of the bytes that are there, and goes on into
 * another stream as it is. Layers are unpacked when layer() asks for one, 4 bytes a cell (1 GB for
 * the largest window, kMaxCellsASide); summary() and the texts unpack them piece by piece, in less
 * than 1 MB. A stream that is damaged or made up throws std::runtime_error when it is read, and
 * leaves all as it was; what is wrong inside of a layer throws it when the layer is unpacked. */
class CObservationTraversability : public mrpt::obs::CObservation
{
  DEFINE_SERIALIZABLE(CObservationTraversability, talus)

 public:
  CObservationTraversability() = default;
  /** Copies the layers of a map. `T_base_sensor`: where the sensor that made it is mounted. */
  CObservationTraversability(
      const ElevationMapper& map, const mrpt::poses::CPose3D& T_map_base,
      const std::vector<Layer>& which = default_layers());

  /** elevation, ground_elevation, state, traversability. */
  static const std::vector<Layer>& default_layers();

  mrpt::poses::CPose3D T_map_base;  //!< the robot in the map frame at `timestamp`
  mrpt::poses::CPose3D T_base_sensor;  //!< the sensor on the robot, of getSensorPose()
  Window window;  //!< where the cells lie; no cells: an empty snapshot

  /** Whether it was stored. */
  bool has_layer(Layer l) const;
  /** window.cells^2 values, index = iy * cells + ix, NaN: unknown; or empty. */
  const std::vector<float>& layer(Layer l) const;
  /** Replaces a layer, or removes it where there are no values. */
  void set_layer(Layer l, std::vector<float> values);

  /** What exportTxtDataRow() tells. Fractions are of all cells of the window, [0,1]; a layer that
   * was not stored counts as unknown. Throws std::runtime_error, as writing into a stream does,
   * where a layer has not as many values as the window has cells. */
  struct Summary
  {
    /** By `state`. */
    double measured = 0, filled_two_sided = 0, filled_one_sided = 0, presumed = 0;
    /** Traversability above 0, 0, none. */
    double free = 0, blocked = 0, unknown = 0;
    /** Middle of the nearest blocked cell: distance from the base [m] and direction from its x axis
     * [rad], seen from above. NaN when there is none. */
    double nearest_m = 0, nearest_rad = 0;
    /** The same along the heading, within half a corridor to either side. NaN: none. */
    double ahead_m = 0;
    /** Map frame [m]; NaN: no ground known. */
    double min_ground_m = 0, max_ground_m = 0;
    /** Of the cells with ground. */
    double coverage() const { return measured + filled_two_sided + filled_one_sided + presumed; }
  };
  /** Of Summary::ahead_m. */
  static constexpr double kHalfCorridor_m = 0.35;
  /** Made anew by each call. */
  Summary summary() const;

  /** @name Virtual methods of CObservation
   *  @{ */
  TALUS_GET_SENSOR_POSE(T_base_sensor)
  /** Sets T_base_sensor. */
  void setSensorPose(const mrpt::poses::CPose3D& pose) override { T_base_sensor = pose; }
  /** For `rawlog-edit --describe`. Throws as layer(). */
  void getDescriptionAsText(std::ostream& o) const override;
  /** For `rawlog-edit --export-txt`. */
  bool exportTxtSupported() const override { return true; }
  /** Names of the columns. */
  std::string exportTxtHeader() const override;
  /** One row of them. Throws as summary(). */
  std::string exportTxtDataRow() const override;
  /** @} */

 private:
  /** Calls `take` with the values of a layer, one part behind the other. */
  void forEachValue(
      Layer l, const std::function<void(const float* values, std::size_t count)>& take) const;
  void requireSound() const;

  // By Layer. What came from a stream is packed, and beside it unpacked once somebody has asked.
  mutable std::array<std::vector<float>, kLayerCount> m_values;
  std::array<std::shared_ptr<const detail::PackedLayer>, kLayerCount> m_packed;
};

}  // namespace talus
