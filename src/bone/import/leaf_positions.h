// Positions of the voxels of a leaf in the lattice of a CT.
#pragma once

#include <glm/mat3x3.hpp>

#include "bone/grid/build.h"
#include "bone/import/spline_field.h"
#include "bone/import/volume.h"

namespace kerf {

/// Map from the world to the voxels of a CT.
struct LatticeMap {
  glm::dmat3 voxel_from_world;
  Vec3 origin_W;

  explicit LatticeMap(const Volume& lattice);
  Vec3 VoxelFromWorld(const Vec3& p_W) const { return voxel_from_world * (p_W - origin_W); }
  /// Returns whether CalcPositions() is possible for leaves with voxels of this size: the CT's axes are those of the
  /// world, and its voxels are not much smaller.
  bool HasPositions(double voxel_mm) const;
  /// Returns the positions along each axis, of which those of the voxels consist, bit for bit.
  LatticePositions CalcPositions(const LeafPlace& leaf) const;
};

}  // namespace kerf
