#include "arrays.h"

namespace talus::python
{
std::string shape_text(const py::array& a)
{
  std::string text = py::str(a.dtype());
  text += " (";
  for (py::ssize_t i = 0; i < a.ndim(); i++) text += (i ? ", " : "") + std::to_string(a.shape(i));
  return text + (a.ndim() == 1 ? ",)" : ")");
}

void refuse_masked(const py::object& value, const std::string& name)
{
  if (py::hasattr(value, "mask")) throw py::value_error(name + ": is masked: fill it with NaN");
}

Table::Table(const py::object& value, const char* name, py::ssize_t columns)
{
  const auto wrong = [&](const std::string& is)
  {
    return py::value_error(
        std::string(name) + ": must be an array of float32 or float64 of shape (N, " +
        std::to_string(columns) + ") or with more columns, is " + is);
  };
  if (!py::isinstance<py::array>(value))
    throw wrong("a " + std::string(py::str(py::type::of(value).attr("__name__"))));
  array_ = py::reinterpret_borrow<py::array>(value);
  is_float_ = array_.dtype().equal(py::dtype::of<float>());
  const bool known = is_float_ || array_.dtype().equal(py::dtype::of<double>());
  refuse_masked(value, name);
  if (!known || array_.ndim() != 2 || array_.shape(1) < columns) throw wrong(shape_text(array_));
  if (!array_.attr("flags").attr("aligned").cast<bool>()) throw wrong("not aligned");
  first_ = static_cast<const char*>(array_.data());
  row_bytes_ = array_.strides(0);
  column_bytes_ = array_.strides(1);
}

Pose pose_from(const py::object& value, const char* name)
{
  const auto array = py::array_t<double, py::array::forcecast>::ensure(value);
  if (!array || array.ndim() != 2 || array.shape(1) != 4 ||
      (array.shape(0) != 4 && array.shape(0) != 3))
  {
    PyErr_Clear();
    throw py::value_error(
        std::string(name) + ": must be a rigid transform of shape (4, 4) or (3, 4), is " +
        (array ? shape_text(array) : std::string(py::str(py::type::of(value)))));
  }
  Pose out;
  for (py::ssize_t i = 0; i < 12; i++)
  {
    const double v = array.at(i / 4, i % 4);
    if (!std::isfinite(v)) throw py::value_error(std::string(name) + ": holds NaN or infinity");
    out.m[static_cast<std::size_t>(i)] = v;
  }
  const auto& m = out.m;
  const double volume = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                        m[2] * (m[4] * m[9] - m[5] * m[8]);
  bool rigid = std::abs(volume - 1) < 0.01;
  for (py::ssize_t i = 0; array.shape(0) == 4 && i < 4; i++)
    rigid = rigid && array.at(3, i) == static_cast<double>(i == 3);
  if (!rigid)
    throw py::value_error(
        std::string(name) + ": must be [R t; 0 0 0 1] with a rotation R; is it transposed?");
  return out;
}

std::optional<Pose> optional_pose(const py::object& value, const char* name)
{
  if (value.is_none()) return std::nullopt;
  return pose_from(value, name);
}

std::vector<float> values_from(const py::object& value, const std::string& name, std::size_t size)
{
  if (value.is_none()) return {};
  refuse_masked(value, name);
  const auto array = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(value);
  if (!array || array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != size)
  {
    PyErr_Clear();
    throw py::value_error(
        name + ": must be numbers of shape (" + std::to_string(size) + ",), one a point, is " +
        (array ? shape_text(array) : std::string(py::str(py::type::of(value)))));
  }
  return {array.data(), array.data() + size};
}

void PointsOfFrame::fill(const Table& points, const PointArrays& to)
{
  frame.x_m = to.x_m;
  frame.y_m = to.y_m;
  frame.z_m = to.z_m;
  for (py::ssize_t i = 0; i < points.rows(); i++)
  {
    to.x_m[i] = static_cast<float>(points.at(i, 0));
    to.y_m[i] = static_cast<float>(points.at(i, 1));
    to.z_m[i] = static_cast<float>(points.at(i, 2));
  }
}
}  // namespace talus::python

PYBIND11_MODULE(_talus, m)
{
  m.attr("__version__") = TALUS_VERSION;
  talus::python::bind_map(m);
  talus::python::bind_nav(m);
#ifdef TALUS_READS_FILES
  talus::python::bind_sources(m);
#endif
  // That of `object` ends the program for protocols 0 and 1: pybind11's base class has no
  // instances.
  namespace py = pybind11;
  for (const auto& [name, type] : m.attr("__dict__").cast<py::dict>())
    if (PyType_Check(type.ptr()))
      type.attr("__reduce__") = py::cpp_function(
          [](const py::object& self) -> py::tuple
          {
            throw py::type_error(
                "cannot copy or pickle " + std::string(py::str(py::type::of(self))) +
                "; Map.save() returns the state of a map");
          },
          py::is_method(type));
}
