// Bone as a formula less the exact places where the disc has been.
#pragma once

#include <functional>
#include <memory>

#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Uncut bone as functions of a world point. Must be callable from several threads at once.
struct ExactSolid {
  struct Material {
    int region = 0;  // 0: none
    double E_MPa = 0;
    double nu = 0;
  };
  /// mm, negative inside, zero on the surface; about a distance near it (gradient between 0.5 and 2).
  std::function<double(const Vec3&)> distance_mm;
  /// Also asked a little outside of the bone.
  std::function<Material(const Vec3&)> material;
};

/// Distances are to the solid less all that was swept: max(solid, -distance to what was swept).
///
/// Each sweep is a stadium as thick as the disc, in the plane of the orientation half-way (docs/physics.md, Removal);
/// what of the motion goes along the spindle is put in the middle. So steps must be small against the thickness.
/// Outside of all sweeps the distance to them is exact; within, it is how deep the deepest single sweep holds the
/// point, so not more than the true depth.
///
/// Sweeps that go straight on in one plane are made one, which they are. Groups of 8 sweeps, and of 8 such groups and
/// so on, are bounded by a stadium about the way from the first to the last centre and by the hole that their discs
/// have in common; a query looks into the groups that could be nearer, the nearest first.
class ExactBone {
 public:
  ExactBone(ExactSolid solid, const DiscSaw& saw);
  ~ExactBone();
  ExactBone(ExactBone&&) noexcept;
  ExactBone& operator=(ExactBone&&) noexcept;

  /// The disc, or only its rim from `edge_mm` inside the rim outwards (0: all of it), goes from a to b.
  /// Left out where it is surely in the air.
  void Sweep(const Pose& X_a, const Pose& X_b, double edge_mm);

  double Distance(const Vec3& p_W) const;
  /// Distance(p_W) < 0 but for rounding, and faster.
  bool IsBone(const Vec3& p_W) const { return solid().distance_mm(p_W) < 0 && !IsSwept(p_W); }
  bool IsSwept(const Vec3& p_W) const;
  /// To what was swept, negative within; `most_mm` where it is no less than that, which is then known faster. It is
  /// looked no further once it is below `enough_mm`: then any figure below that.
  double SweptDistance(const Vec3& p_W, double most_mm, double enough_mm) const;
  double SweptDistance(const Vec3& p_W, double most_mm) const;
  /// Volume of what was swept of the solid, mm^3: cells are halved as long as a surface may go through them, down to
  /// `finest_mm`; there, by the distance to it. Errors: of the order of finest_mm^2 for each mm of sharp edge.
  double CalcRemoved(double finest_mm) const;
  const ExactSolid& solid() const;
  /// A box around all that was swept; lower > upper when nothing was.
  Box3 swept_bounds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
