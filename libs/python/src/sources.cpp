#include <talus/import/scan_source.h>
#include <talus/io/geotiff.h>
#include <talus/mrpt/observation_points.h>
#include <talus/site/site_geotiff.h>

#include <map>
#include <optional>
#include <set>

#include "arrays.h"

namespace talus::python
{
using namespace py::literals;

constexpr double kMaxGap_s = 0.5;  // between poses, as that of talus-map

/** The scans of a source with their poses. */
class Frames
{
 public:
  Frames(
      const std::vector<std::string>& paths, const std::string& poses,
      const std::map<std::string, py::object>& mounts, const std::vector<std::string>& topics,
      bool poses_of_sensor)
  {
    options_.topics = topics;
    options_.poses_of_sensor = poses_of_sensor;
    options_.poses = poses;
    for (const auto& [label, T] : mounts)
    {
      const Pose p = pose_from(T, ("mounts['" + label + "']").c_str());
      mrpt::math::CMatrixDouble44 matrix = mrpt::math::CMatrixDouble44::Identity();
      for (int i = 0; i < 12; i++) matrix(i / 4, i % 4) = p.m[static_cast<std::size_t>(i)];
      options_.mountings[label] = mrpt::poses::CPose3D(matrix);
    }
    const WithoutGil release;
    inputs_ = import::inputs_of(paths);
    if (inputs_.size() != 1)
      throw std::invalid_argument("frames(): one source at a time; several bags count as one");
    source_ = open();
    poses_ = source_->poses();
    if (!poses_.empty()) return;
    // A bag knows its poses once it was read.
    import::ImportedScan scan;
    bool all_have_poses = true;
    while (source_->next(scan)) all_have_poses = all_have_poses && scan.T_map_sensor;
    poses_ = source_->poses();
    if (poses_.empty() && !all_have_poses)
      throw std::runtime_error(
          paths.front() + ": has no poses of the robot: frames(..., poses=FILE) takes them");
    source_ = open();
  }

  py::dict next()
  {
    import::ImportedScan scan;
    std::optional<mrpt::poses::CPose3D> T_map_sensor;
    {
      const WithoutGil release;
      do
      {
        if (!source_->next(scan)) break;
        T_map_sensor = scan.T_map_sensor;
        const auto T_map_base = poses_.at(scan.time_s, kMaxGap_s);
        if (!T_map_sensor && T_map_base) T_map_sensor = *T_map_base + scan.T_base_sensor;
      } while (!T_map_sensor);
    }
    if (!T_map_sensor) throw py::stop_iteration();
    return frame_of(scan, *T_map_sensor);
  }

 private:
  std::unique_ptr<import::ScanSource> open() const
  {
    return import::open_scan_source(inputs_.front(), options_);
  }

  static py::array matrix_of(const mrpt::poses::CPose3D& T)
  {
    const Pose p = talus::pose_from(T);
    py::array_t<double> out({4, 4});
    for (py::ssize_t i = 0; i < 16; i++)
      out.mutable_at(i / 4, i % 4) =
          i < 12 ? p.m[static_cast<std::size_t>(i)] : static_cast<double>(i == 15);
    return std::move(out);
  }

  py::dict frame_of(import::ImportedScan& scan, const mrpt::poses::CPose3D& T_map_sensor)
  {
    // Columns one after the other: Map.update() reads them where they are.
    const auto n = static_cast<py::ssize_t>(scan.x_m.size());
    auto columns = std::make_shared<std::vector<float>>(std::move(scan.x_m));
    for (const auto* more : {&scan.y_m, &scan.z_m})
      columns->insert(columns->end(), more->begin(), more->end());
    const py::array rows = as_array<float>(std::move(columns), {3, n});
    const auto sensor = sensors_.emplace(scan.sensor_label, sensors_.size()).first->second;
    py::dict out(
        "points"_a = rows.attr("T"), "T_map_sensor"_a = matrix_of(T_map_sensor),
        "T_base_sensor"_a = matrix_of(scan.T_base_sensor), "t"_a = scan.time_s,
        "sensor"_a = sensor);
    if (!scan.point_time_s.empty())
    {
      out["path"] = path_of(scan);
      out["times"] = as_array(std::move(scan.point_time_s));
    }
    return out;
  }

  /** Of the sensor, while it scanned. */
  py::list path_of(const import::ImportedScan& scan) const
  {
    constexpr int kPoses = 11;
    float first = HUGE_VALF, last = -HUGE_VALF;
    for (const float t : scan.point_time_s)
    {
      first = std::fmin(first, t);
      last = std::fmax(last, t);
    }
    py::list path;
    for (int i = 0; last > first && i < kPoses; i++)
    {
      const double t = first + (static_cast<double>(last) - first) * i / (kPoses - 1);
      if (const auto T = poses_.at(scan.time_s + t, kMaxGap_s))
        path.append(py::make_tuple(t, matrix_of(*T + scan.T_base_sensor)));
    }
    return path.size() < 2 ? py::list() : path;
  }

  import::SourceOptions options_;
  std::vector<import::Input> inputs_;
  std::unique_ptr<import::ScanSource> source_;
  io::Trajectory poses_;
  std::map<std::string, std::size_t> sensors_;
};

/** The bands of a site's file, each read when it is asked for. */
class SiteFile
{
 public:
  explicit SiteFile(const std::string& path) : file_(path), bands_(file_.bands())
  {
    (void)site::info_of_site(path);  // or it says that it is none
  }

  const std::vector<std::string>& bands() const { return bands_; }

  /** With where it lies: (H, W), min x, min y, resolution. */
  py::tuple band(const std::string& name) const
  {
    io::LayerStack stack;
    {
      const WithoutGil release;
      stack = file_.read({name});
    }
    if (stack.layers.empty()) throw py::key_error("'" + name + "': no band of this site");
    auto values = std::make_shared<const std::vector<float>>(std::move(stack.layers.front()));
    return py::make_tuple(
        as_array<float>(std::move(values), {stack.cells_y, stack.cells_x}), stack.min_x_m,
        stack.min_y_m, stack.resolution_m);
  }

 private:
  io::GeotiffFile file_;
  std::vector<std::string> bands_;
};

void bind_sources(py::module_& m)
{
  py::class_<Frames>(m, "Frames")
      .def(
          py::init<
              std::vector<std::string>, std::string, std::map<std::string, py::object>,
              std::vector<std::string>, bool>(),
          "paths"_a, "poses"_a, "mounts"_a, "topics"_a, "poses_of_sensor"_a)
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &Frames::next);
  py::class_<SiteFile>(m, "SiteFile")
      .def(py::init<std::string>())
      .def_property_readonly("bands", &SiteFile::bands)
      .def("band", &SiteFile::band);
}

}  // namespace talus::python
