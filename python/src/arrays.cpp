#include "arrays.h"

#include <glm/mat3x3.hpp>
#include <new>

#include "kerf/error.h"

namespace kerf::python {
namespace {

std::string ShapeOf(const DoubleArray& array) {
  return py::cast<std::string>(py::str(py::tuple(array.attr("shape"))));
}

DoubleArray ToArray(const py::handle& value, const char* name) {
  const char kind = py::isinstance<py::array>(value) ? py::reinterpret_borrow<py::array>(value).dtype().kind() : '?';
  if (kind == 'c') throw Error(std::string(name) + " must be an array of real numbers");
  DoubleArray array = TryArray<DoubleArray>(value);
  if (array) return array;
  if (kind == 'f' || kind == 'i' || kind == 'u') throw std::bad_alloc();  // its copy does not fit in memory
  throw Error(std::string(name) + " must be an array of numbers");
}

Pose ReadMatrix(const double* m, const char* name) {
  const glm::dmat3 R(Vec3(m[0], m[4], m[8]), Vec3(m[1], m[5], m[9]), Vec3(m[2], m[6], m[10]));
  const glm::dmat3 error = glm::transpose(R) * R - glm::dmat3(1);
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) largest = std::max(largest, std::abs(error[i][j]));
  }
  const bool last_row = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1;
  if (!(largest < 1e-6) || !(glm::determinant(R) > 0) || !last_row) {
    throw Error(std::string(name) + ": a matrix of 4 x 4 is not a rotation and a translation");
  }
  return {glm::normalize(glm::quat_cast(R)), {m[3], m[7], m[11]}};
}

Pose ReadRow(const double* p, std::size_t numbers, const char* name) {
  if (numbers == 16) return ReadMatrix(p, name);
  Pose X;
  X.p_AB = {p[0], p[1], p[2]};
  if (numbers == 7) X.R_AB = Quat(p[3], p[4], p[5], p[6]);
  return X;
}

}  // namespace

Vec3 ToVec3(const py::handle& value, const char* name) {
  const DoubleArray array = ToArray(value, name);
  if (array.ndim() != 1 || array.size() != 3) {
    throw Error(std::string(name) + " must have 3 numbers; its shape is " + ShapeOf(array));
  }
  return {array.data()[0], array.data()[1], array.data()[2]};
}

Pose ToPose(const py::handle& value, const char* name) {
  const DoubleArray array = ToArray(value, name);
  const bool row = array.ndim() == 1 && (array.size() == 3 || array.size() == 7);
  if (!row && !(array.ndim() == 2 && array.shape(0) == 4 && array.shape(1) == 4)) {
    throw Error(std::string(name) + " must have 3 numbers, 7 numbers, or 4 x 4; its shape is " + ShapeOf(array));
  }
  return ReadRow(array.data(), static_cast<std::size_t>(array.size()), name);
}

std::vector<Pose> ToPoses(const py::handle& value, const char* name) {
  const DoubleArray array = ToArray(value, name);
  const bool rows = array.ndim() == 2 && (array.shape(1) == 3 || array.shape(1) == 7);
  if (!rows && !(array.ndim() == 3 && array.shape(1) == 4 && array.shape(2) == 4)) {
    throw Error(std::string(name) + " must have the shape (n, 3), (n, 7) or (n, 4, 4); it is " + ShapeOf(array));
  }
  const std::size_t numbers = rows ? static_cast<std::size_t>(array.shape(1)) : 16;
  std::vector<Pose> poses(static_cast<std::size_t>(array.shape(0)));
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = ReadRow(array.data() + i * numbers, numbers, name);
  return poses;
}

std::vector<Vec3> ToPoints(const py::handle& value, const char* name) {
  const DoubleArray array = ToArray(value, name);
  if (array.ndim() != 2 || array.shape(1) != 3) {
    throw Error(std::string(name) + " must have the shape (n, 3); it is " + ShapeOf(array));
  }
  std::vector<Vec3> points(static_cast<std::size_t>(array.shape(0)));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double* p = array.data() + 3 * i;
    points[i] = {p[0], p[1], p[2]};
  }
  return points;
}

std::vector<double> ToNumbers(const py::handle& value, std::size_t count, const char* name) {
  const DoubleArray array = ToArray(value, name);
  const auto size = static_cast<std::size_t>(array.size());
  if (array.ndim() == 0) return std::vector<double>(count, *array.data());
  if (array.ndim() != 1 || size != count) {
    throw Error(std::string(name) + " must be a number, or have " + std::to_string(count) +
                ", one for each pose; its shape is " + ShapeOf(array));
  }
  return {array.data(), array.data() + count};
}

py::object ToScalar(const py::handle& value) {
  if (py::hasattr(value, "item") && py::hasattr(value, "ndim") && py::cast<int>(value.attr("ndim")) == 0) {
    return value.attr("item")();
  }
  return py::reinterpret_borrow<py::object>(value);
}

py::array_t<double> FromVec3(const Vec3& v) {
  py::array_t<double> array(3);
  double* p = array.mutable_data();
  p[0] = v.x, p[1] = v.y, p[2] = v.z;
  return array;
}

py::array_t<double> FromPose(const Pose& X) {
  py::array_t<double> array(7);
  double* p = array.mutable_data();
  p[0] = X.p_AB.x, p[1] = X.p_AB.y, p[2] = X.p_AB.z;
  p[3] = X.R_AB.w, p[4] = X.R_AB.x, p[5] = X.R_AB.y, p[6] = X.R_AB.z;
  return array;
}

py::array MovePoints(std::vector<Vec3>&& points) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  auto* kept = new std::vector<Vec3>(std::move(points));
  py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<Vec3>*>(p); });
  return py::array_t<double>({static_cast<py::ssize_t>(kept->size()), py::ssize_t{3}},
                             reinterpret_cast<const double*>(kept->data()), owner);
}

void ColumnLister::operator()(const std::string& name, const Vec3&) {
  const std::size_t at = name.find("{}");
  for (const char* part : {"x", "y", "z"}) Add(std::string(name).replace(at, 2, part), "<f8");
}

py::array Table::Take() {
  const py::dtype type = py::dtype::from_args(columns_);
  auto* kept = new std::vector<std::uint64_t>(std::move(cells_));
  py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<std::uint64_t>*>(p); });
  const std::size_t rows = width_ == 0 ? 0 : kept->size() / width_;
  cells_.clear();
  return py::array(type, {static_cast<py::ssize_t>(rows)}, {}, kept->data(), owner);
}

}  // namespace kerf::python
