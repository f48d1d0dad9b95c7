// Distances between points of a surface and the triangles around a place, for reduce.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

using Vec3f = glm::vec3;

/// A triangle with a corner at the place. Lengths are in mm from the place, in single precision, which is sufficient
/// so close to it.
struct PlaceTriangle {
  Vec3f from{0}, to{0};        // the other corners; seen from outside, anticlockwise
  Vec3f normal{0};             // unit
  Vec3f in_from{0}, in_to{0};  // in the plane, perpendicular to a side at the place, into the triangle
  Vec3f in_opposite{0};        // the same for the opposite side
  float to_opposite = 0;       // added to the product with in_opposite: 0 on the opposite side

  PlaceTriangle(const Vec3f& from_corner, const Vec3f& to_corner);
  float CalcArea_mm2() const { return 0.5F * to_opposite; }
  /// Returns the squared distance from a point to the nearest of the sides beyond which it lies; if there are none,
  /// a large number.
  float CalcDistance2BeyondSides(const Vec3f& p) const;
};

/// Points with normals near a place.
class NearPoints {
 public:
  static constexpr float kFar = 1e30F;

  /// The nearest of several triangles.
  struct Nearest {
    float distance2 = kFar;
    int triangle = -1;
    float least_cosine = 1;  // of the angle to the normals of all triangles within the limit
  };

  std::size_t size() const { return size_; }
  void Resize(std::size_t size);
  void Set(std::size_t i, const Vec3f& p, const Vec3f& n) {
    Row(0)[i] = p.x, Row(1)[i] = p.y, Row(2)[i] = p.z;
    Row(3)[i] = n.x, Row(4)[i] = n.y, Row(5)[i] = n.z;
  }
  Vec3f point(std::size_t i) const { return {Row(0)[i], Row(1)[i], Row(2)[i]}; }
  Vec3f normal(std::size_t i) const { return {Row(3)[i], Row(4)[i], Row(5)[i]}; }

  /// Finds, for all points, the nearest of the triangles above or below which the point lies and whose normal is at an
  /// angle to the point's of a cosine of at least `min_cosine`. `limit2` bounds the triangles in least_cosine.
  void FindNearest(std::span<const PlaceTriangle> triangles, float limit2, float min_cosine);
  Nearest nearest(std::size_t i) const { return {Row(6)[i], static_cast<int>(Row(7)[i]), Row(8)[i]}; }

  /// Returns the indices of the three points closest to `p`; fewer if there are fewer points.
  std::span<const std::size_t> FindClosest(Vec3f p);

 private:
  static constexpr std::size_t kRows = 10;  // position, normal, nearest triangle (3), squared distance
  const float* Row(std::size_t row) const { return values_.data() + row * stride_; }
  float* Row(std::size_t row) { return values_.data() + row * stride_; }

  std::size_t size_ = 0;
  std::size_t stride_ = 0;  // a multiple of the length of a vector
  std::vector<float> values_;
  std::array<std::size_t, 3> closest_{};
};

}  // namespace kerf
