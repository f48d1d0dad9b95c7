// Samples of a grid at many points at once, computed with vector instructions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <vector>

#include "bone/grid/phi_table.h"
#include "kerf/geometry.h"

namespace kerf {

/// Points, by coordinates. The coordinates can be read up to the next multiple of kPadding; what follows the last point
/// is finite.
class PointList {
 public:
  static constexpr std::size_t kPadding = 8;
  std::size_t size() const { return size_; }
  const double* x() const { return x_.data(); }
  const double* y() const { return y_.data(); }
  const double* z() const { return z_.data(); }
  /// Makes room for `capacity` points and removes all. Allocates.
  void Reserve(std::size_t capacity) {
    for (std::vector<double>* values : {&x_, &y_, &z_}) values->resize(capacity + kPadding);
    size_ = 0;
  }
  void Clear() { size_ = 0; }
  /// There must be room. Tick-safe.
  void Add(const Vec3& p) {
    x_[size_] = p.x;
    y_[size_] = p.y;
    z_[size_++] = p.z;
  }

 private:
  std::vector<double> x_, y_, z_;
  std::size_t size_ = 0;
};

/// Maps the points p of a list to R p + t.
struct PointMap {
  glm::dmat3 R{1};
  Vec3 t{0};
};
/// Maps points to the index space of another grid: scale p / voxel_mm + offset.
struct GridMap {
  double scale = 1;
  double voxel_mm = 1;
  Vec3 offset{0};
};
/// Two constants of each region, by id.
struct RegionConstants {
  std::array<double, 256> a{}, b{};
};

/// Interpolates both fields trilinearly at each point, in the index space of their grid. `whole`, `cut`: one value per
/// point. In a cell whose leaves are not split and do not hold different fields, the values of the field that its
/// leaves hold are interpolated, and the other has the value of the inside leaf. The bits are those of Interpolate() at
/// FindCell(), with every vector instruction set. Tick-safe.
void SamplePoints(const PhiTable& table, const PointMap& map, const PointList& points, double* whole, double* cut);
/// Does the same and returns only phi, the larger of the two.
void SamplePhi(const PhiTable& table, const PointMap& map, const PointList& points, double* phi);
/// Does the same as SamplePoints() for one point, with the same bits.
PhiPair SamplePoint(const PhiTable& table, const Vec3& p_vox);

/// Finds for each point the region in `of_leaf` of the leaf with the lowest corner of the point's cell; `of_leaf`: one
/// id for each place of a table with this box. Then interpolates the constants of that region between the eight
/// corners. The bits are those of the sums of VisitRegions(), divided by the sum of its weights. Tick-safe.
void InterpolateUniform(const TableBox& box, const std::uint8_t* of_leaf, const PointMap& map, const GridMap& to_index,
                        const PointList& points, const RegionConstants& constants, std::uint8_t* regions, double* a,
                        double* b);

}  // namespace kerf
