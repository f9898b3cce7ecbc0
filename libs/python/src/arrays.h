#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <talus/elevation_mapper.h>
#include <talus/map_view.h>
#include <talus/nav/heading_cost.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace talus::python
{
namespace py = pybind11;

/** A vector as a read-only array of this shape, which keeps it alive. */
template <class T>
py::array as_array(std::shared_ptr<const std::vector<T>> values, std::vector<py::ssize_t> shape)
{
  using Owner = std::shared_ptr<const std::vector<T>>;
  const T* first = values->data();
  const py::capsule owner(
      new Owner(std::move(values)), [](void* p) { delete static_cast<Owner*>(p); });
  py::array out(py::dtype::of<T>(), std::move(shape), first, owner);
  out.attr("setflags")(py::arg("write") = false);
  return out;
}

/** The same of a vector that nobody else has. */
template <class T>
py::array as_array(std::vector<T> values)
{
  const auto size = static_cast<py::ssize_t>(values.size());
  return as_array(std::make_shared<const std::vector<T>>(std::move(values)), {size});
}

/** Says what an argument is. */
std::string shape_text(const py::array& a);
/** Throws ValueError for an array with a mask, whose values would be read. */
void refuse_masked(const py::object& value, const std::string& name);

/** Numbers of an argument, float32 or float64, in an array of two dimensions with `columns` or more
 * columns; any strides. Throws ValueError that names the argument. */
class Table
{
 public:
  Table(const py::object& value, const char* name, py::ssize_t columns);

  py::ssize_t rows() const { return array_.shape(0); }
  /** Without a lock of Python. */
  double at(py::ssize_t row, py::ssize_t column) const
  {
    const char* p = first_ + row * row_bytes_ + column * column_bytes_;
    return is_float_ ? static_cast<double>(*reinterpret_cast<const float*>(p))
                     : *reinterpret_cast<const double*>(p);
  }
  /** A column of floats one after the other, as those of a transposed array of three rows; null:
   * they lie apart. */
  const float* column(py::ssize_t c) const
  {
    const bool dense = is_float_ && row_bytes_ == static_cast<py::ssize_t>(sizeof(float));
    return dense ? reinterpret_cast<const float*>(first_ + c * column_bytes_) : nullptr;
  }

 private:
  py::array array_;
  const char* first_;
  py::ssize_t row_bytes_, column_bytes_;
  bool is_float_;
};

/** (4, 4) or (3, 4). Throws ValueError that names the argument; also for what is not finite. */
Pose pose_from(const py::object& value, const char* name);
std::optional<Pose> optional_pose(const py::object& value, const char* name);

/** Numbers, one for each of `size`; empty for None. Throws ValueError that names the argument. */
std::vector<float> values_from(const py::object& value, const std::string& name, std::size_t size);

/** A frame with the memory that it needs, taken of the arguments of Map.update(). */
struct PointsOfFrame
{
  /** Points from `to`, where they are not dense columns already. */
  void fill(const Table& points, const PointArrays& to);

  Frame frame;
  std::vector<float> time_s;
  std::vector<std::vector<float>> channels;
};

/** A map with a lock: calls of several threads run one after the other, without Python's lock. */
struct Map
{
  Map(const Parameters& p, Backend backend, int threads, int device)
      : mapper(p, backend, threads, device)
  {
  }

  std::mutex mutex;
  ElevationMapper mapper;
  double last_s = NAN;
  /** Layers that were asked for since the last frame: arrays stay as they are. */
  std::map<std::string, std::shared_ptr<const std::vector<float>>> layers;
  std::uint64_t frames = 0;  //!< and other changes

  /** After a change. */
  void forget_layers()
  {
    layers.clear();
    frames++;
  }
};

/** Without Python's lock, as py::gil_scoped_release; but a thread that wants it back after the
 * interpreter has left sleeps until the process ends. Python would unwind it, out of a destructor,
 * which ends the program with SIGABRT. */
class WithoutGil
{
 public:
  WithoutGil() = default;
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil()
  {
    try
    {
      PyEval_RestoreThread(state_);
    }
    catch (...)
    {
      for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
    }
  }

 private:
  PyThreadState* state_ = PyEval_SaveThread();
};

/** work() with the map, without Python's lock. */
template <class Work>
auto locked(Map& map, const Work& work)
{
  const WithoutGil release;
  const std::lock_guard lock(map.mutex);
  return work(map.mapper);
}

class Frames;
class SiteFile;

void bind_map(py::module_& m);
void bind_nav(py::module_& m);
void bind_sources(py::module_& m);

}  // namespace talus::python

namespace pybind11::detail
{
/** Takes no object that __new__() made without __init__(): pybind11 would hand out memory as it is.
 */
template <class T>
class type_caster<
    T, enable_if_t<any_of<
           std::is_same<T, talus::python::Map>, std::is_same<T, talus::FrameReport>,
           std::is_same<T, talus::nav::Footprint>, std::is_same<T, talus::python::Frames>,
           std::is_same<T, talus::python::SiteFile>>::value>> : public type_caster_base<T>
{
 public:
  bool load(handle src, bool convert)
  {
    return type_caster_base<T>::load(src, convert) &&
           (src.is_none() ||
            reinterpret_cast<instance*>(src.ptr())->get_value_and_holder().holder_constructed());
  }
};
}  // namespace pybind11::detail
