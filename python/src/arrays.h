// Exchange of numbers with NumPy: points, poses, and tables with named columns.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "kerf/geometry.h"

namespace kerf::python {

namespace py = pybind11;

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Converts to an array; if that is impossible, the result is null. Passes on an interrupt of the user, which
/// Array::ensure() would swallow.
template <typename Array>
Array TryArray(const py::handle& value) {
  try {
    return Array(py::reinterpret_borrow<py::object>(value));
  } catch (const py::error_already_set& e) {
    if (e.matches(PyExc_KeyboardInterrupt)) throw;
    return py::reinterpret_steal<Array>(py::handle());
  }
}

// Each throws kerf::Error, with `name` as the subject, if the shape is wrong or something is not a number.

/// Reads an array of 3 numbers.
Vec3 ToVec3(const py::handle& value, const char* name);
/// Reads a pose: 3 numbers (a position), 7 numbers (position and unit quaternion w, x, y, z), or a matrix of 4 x 4.
Pose ToPose(const py::handle& value, const char* name);
/// Reads poses, one per row: an array of n x 3, n x 7, or n x 4 x 4.
std::vector<Pose> ToPoses(const py::handle& value, const char* name);
/// Reads points, one per row: an array of n x 3.
std::vector<Vec3> ToPoints(const py::handle& value, const char* name);
/// Reads one number for all of `count` rows, or one for each.
std::vector<double> ToNumbers(const py::handle& value, std::size_t count, const char* name);

/// Returns the Python number of a NumPy scalar, and anything else unchanged.
py::object ToScalar(const py::handle& value);

py::array_t<double> FromVec3(const Vec3& v);
/// Returns 7 numbers: position and quaternion w, x, y, z.
py::array_t<double> FromPose(const Pose& X);

/// Makes an array of a vector's memory, without a copy.
template <typename T>
py::array MoveToArray(std::vector<T>&& values, std::vector<py::ssize_t> shape) {
  auto* kept = new std::vector<T>(std::move(values));
  py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<T>*>(p); });
  return py::array_t<T>(std::move(shape), kept->data(), owner);
}

/// Makes an array of n x 3 of points, without a copy.
py::array MovePoints(std::vector<Vec3>&& points);

/// Visitor that lists the columns of a row.
class ColumnLister {
 public:
  void operator()(const std::string& name, double) { Add(name, "<f8"); }
  void operator()(const std::string& name, std::int64_t) { Add(name, "<i8"); }
  /// Three columns, such as "force_x_N"; `name` has {} in place of the component.
  void operator()(const std::string& name, const Vec3&);
  const py::list& columns() const { return columns_; }
  std::size_t count() const { return columns_.size(); }

 private:
  void Add(const std::string& name, const char* type) { columns_.append(py::make_tuple(name, type)); }
  py::list columns_;
};

/// Rows of a table as a structured NumPy array. A column has 8 bytes: a double or an int64.
class Table {
 public:
  /// `describe(visitor)` visits the columns of an empty row.
  template <typename DescribeRow>
  explicit Table(const DescribeRow& describe) {
    ColumnLister lister;
    describe(lister);
    columns_ = lister.columns();
    width_ = lister.count();
  }
  void Reserve(std::size_t rows) { cells_.reserve(rows * width_); }

  // The visitor of a row. Does not need the interpreter.
  void operator()(const char*, double value) { cells_.push_back(std::bit_cast<std::uint64_t>(value)); }
  void operator()(const char*, std::int64_t value) { cells_.push_back(static_cast<std::uint64_t>(value)); }
  void operator()(const char*, const Vec3& v) {
    for (const double value : {v.x, v.y, v.z}) (*this)("", value);
  }
  void operator()(const std::string&, double value) { (*this)("", value); }

  /// Moves the rows out.
  py::array Take();

 private:
  py::list columns_;
  std::size_t width_ = 0;
  std::vector<std::uint64_t> cells_;
};

}  // namespace kerf::python
