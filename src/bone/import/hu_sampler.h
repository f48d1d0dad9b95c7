// The CT's own numbers between its voxels.
#pragma once

#include "bone/import/volume.h"

namespace kerf {

/// Trilinear between voxel centres; beyond the outermost ones their values go on. Never outside the range of the eight
/// values around: a spline would overshoot at the cortex's edges, and a power law would make much of that. Thread-safe.
class HuSampler {
 public:
  /// `ct` must outlive it.
  explicit HuSampler(const Volume& ct);
  double At(const Vec3& p_W) const;

 private:
  const Volume& ct_;
  glm::dmat3 voxel_from_world_{1};
};

}  // namespace kerf
