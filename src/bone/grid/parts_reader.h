// The two fields of a bone (see BoneField), read from its grids. Includes OpenVDB.
#pragma once

#include <array>

#include "bone/grid/cell_fields.h"
#include "bone/grid/grids.h"

namespace kerf {

/// The bone must outlive the reader and must not change.
class PartsReader {
 public:
  explicit PartsReader(const BoneGrids& grids);

  /// Returns the values of the leaf whose lowest voxel is `origin`. Tick-safe.
  PhiParts At(const openvdb::Coord& origin) const;
  /// Where a field is nowhere near zero in a leaf, At() returns this for it.
  const float* inside() const { return inside_.data(); }
  /// Returns the value of the cut at a voxel, mm.
  float CutAt(const openvdb::Coord& voxel) const {
    return At(voxel & ~7).cut[64 * (voxel.x() & 7) + 8 * (voxel.y() & 7) + (voxel.z() & 7)];
  }
  /// Returns the values of both fields at the corners of a cell.
  PhiCorners Corners(const CellPoint& cell) const;
  /// Returns phi, mm, at a point in the index space of phi: the larger of the two fields, each interpolated.
  double Sample(const Vec3& p_vox) const;
  void Load(const openvdb::Coord& origin, CellFields& fields) const;
  /// Returns whether something was cut in a leaf or one of its 26 neighbours.
  bool IsCutAround(const openvdb::Coord& origin) const;
  const openvdb::FloatGrid::ConstAccessor& phi() const { return phi_; }

 private:
  using Accessor = openvdb::FloatGrid::ConstAccessor;
  std::array<float, 512> outside_, inside_;
  Accessor phi_;
  std::optional<Accessor> whole_, cut_;  // none if no leaf has both fields
};

/// Gives a piece of the bone the two fields of the leaves that it has in common with the bone. Its phi is that of the
/// bone, with other bone replaced by air; its leaves are still those of the bone, those of air included.
void CopyParts(const BoneGrids& bone, BoneGrids& piece);

}  // namespace kerf
