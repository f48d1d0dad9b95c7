// Bone as a formula minus the exact sweeps of the disc.
#pragma once

#include <functional>
#include <memory>

#include "kerf/geometry.h"
#include "kerf/material.h"
#include "kerf/tool.h"

namespace kerf {

/// Uncut bone as functions of a world point. Both functions must be callable from several threads at once.
struct ExactSolid {
  struct Material {
    int region = 0;  // 0: none
    double E_MPa = 0;
    double nu = 0;
    Tissue tissue = Tissue::kCortical;
  };
  /// Signed function, mm, negative inside and zero on the surface. Near the surface it is approximately the distance to
  /// it (gradient between 0.5 and 2).
  std::function<double(const Vec3&)> distance_mm;
  /// This function is also evaluated slightly outside the bone.
  std::function<Material(const Vec3&)> material;
};

/// The distance to the bone is that to the solid minus the whole sweep: max(solid, -distance to the sweep).
///
/// Each step's sweep is a stadium as thick as the disc, in the plane of the orientation halfway through the step
/// (docs/physics.md, Removal). The motion along the spindle is replaced by its midpoint, so steps must be small
/// compared with the thickness. Outside all sweeps the distance to them is exact. Inside, it is the depth of the point
/// in the single sweep in which it is deepest, which is at most the true depth.
///
/// Sweeps that continue straight in one plane are merged, which is exact. Groups of 8 sweeps, and of 8 such groups and
/// so on, are bounded by a stadium about the segment from the first to the last centre and by the hole that their discs
/// have in common. A query visits the groups that could be nearer, nearest first.
class ExactBone {
 public:
  ExactBone(ExactSolid solid, const DiscSaw& saw);
  ~ExactBone();
  ExactBone(ExactBone&&) noexcept;
  ExactBone& operator=(ExactBone&&) noexcept;

  /// Removes the sweep of the disc from a to b, or only that of its outermost `edge_mm` (0: the whole disc). Does
  /// nothing if the disc is certainly in air.
  void Sweep(const Pose& X_a, const Pose& X_b, double edge_mm);

  double Distance(const Vec3& p_W) const;
  /// Returns the same as Distance(p_W) < 0, except for rounding, but faster.
  bool IsBone(const Vec3& p_W) const { return solid().distance_mm(p_W) < 0 && !IsSwept(p_W); }
  bool IsSwept(const Vec3& p_W) const;
  /// Returns the distance to the sweep, negative inside, or `max_mm` if the distance is larger, which makes the query
  /// faster. The search ends as soon as a distance below `enough_mm` is found, which is then returned even if it is not
  /// the smallest.
  double SweptDistance(const Vec3& p_W, double max_mm, double enough_mm) const;
  double SweptDistance(const Vec3& p_W, double max_mm) const;
  /// Returns the volume of the solid inside the sweep, mm^3. Cells that may contain a surface are halved down to
  /// `finest_mm`; there the volume is estimated from the distance. The error is of the order of finest_mm^2 per mm of
  /// sharp edge.
  double CalcRemoved(double finest_mm) const;
  const ExactSolid& solid() const;
  /// Returns the bounding box of the sweep; lower > upper if nothing was swept.
  Box3 swept_bounds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
