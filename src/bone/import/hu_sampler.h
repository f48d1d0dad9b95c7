// The CT's own values between its voxels.
#pragma once

#include "bone/import/volume.h"

namespace kerf {

/// Interpolates trilinearly between voxel centres; constant beyond the outermost ones. The result is never outside the
/// range of the eight surrounding values: a spline would overshoot at the cortex's edges, and a power law would amplify
/// that. Thread-safe.
class HuSampler {
 public:
  /// `ct` must outlive the sampler.
  explicit HuSampler(const Volume& ct);
  double At(const Vec3& p_W) const;

 private:
  const Volume& ct_;
  glm::dmat3 voxel_from_world_{1};
};

}  // namespace kerf
