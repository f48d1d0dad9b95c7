// Parts of circles on the disc that have bone in front of them, and the volume that they remove.
#pragma once

#include <functional>
#include <numbers>
#include <vector>

#include "experiment/reference/exact_bone.h"
#include "kerf/force.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf::reference {

/// A piece of a circle about the spindle, all of it in front of bone of a single region. Angles are measured from the
/// tool's x axis towards its y axis; what the teeth cut is given at both ends, and the moduli are linear in between.
struct Piece {
  double from_rad = 0, to_rad = 0;
  ToothCut cut_from, cut_to;

  ToothCut Cut(double angle_rad) const {
    const double t = to_rad > from_rad ? (angle_rad - from_rad) / (to_rad - from_rad) : 0;
    ToothCut cut = cut_from;
    cut.E_star_MPa = (1 - t) * cut_from.E_star_MPa + t * cut_to.E_star_MPa;
    cut.E_MPa = (1 - t) * cut_from.E_MPa + t * cut_to.E_MPa;
    return cut;
  }
};

/// Returns what a tooth at rest cuts. In the reduced modulus the bone at the point and the tool's steel are two
/// compliances in series. The direction of the osteons is unknown. Empty if there is no material.
ToothCut MakeCut(const ExactSolid::Material& bone, const DiscSaw& saw);

/// The circle to search.
struct Circle {
  double radius_mm = 0;
  double z_mm = 0;
  bool with_material = false;  // whether materials are distinguished; otherwise all bone is treated alike
};

/// Finds the pieces of the circle between two angles that are in the bone. Takes a sample about every 2 pi / `points`
/// along the circle, and locates the ends of the pieces between two samples by bisection to 1e-8 rad.
void FindPieces(const ExactBone& bone, const DiscSaw& saw, const Pose& X_WT, const Circle& circle, double from_rad,
                double to_rad, int points, std::vector<Piece>& pieces);

/// A flux that only determines proportions uses the number of rim points divided by this.
inline constexpr int kFluxFraction = 4;

/// The volume per second that the disc removes from the bone, mm^3/s: the integral of the outward speed of the disc's
/// surface over the part of this surface that is in uncut bone. `X_WT` is the pose halfway through the step; the bone
/// is that at the start of the step.
class Flux {
 public:
  /// `flats` is true if the flats remove bone too.
  Flux(const DiscSaw& saw, int rim_points, double flat_spacing_mm, bool flats);
  /// Takes the velocity of the tool's origin and the angular velocity, both in the tool frame.
  double Calc(const ExactBone& bone, const Pose& X_WT, const Vec3& v_T_mm_per_s, const Vec3& w_T_rad_per_s) const;

 private:
  double CalcRim(const ExactBone& bone, const Pose& X_WT, const Vec3& v, const Vec3& w) const;
  double CalcFlats(const ExactBone& bone, const Pose& X_WT, const Vec3& v, const Vec3& w) const;

  DiscSaw saw_;
  int rim_points_;
  double flat_spacing_mm_;
  bool flats_;
};

// ---- interpolation of poses
/// Returns the pose at `fraction` of the motion from a to b: straight line, uniform rotation.
Pose Between(const Pose& X_a, const Pose& X_b, double fraction);
/// Returns the rotation vector that takes `R_a` to `R_b`, in the frame of a, rad.
Vec3 TurnBetween(const Quat& R_a, const Quat& R_b);
/// Returns `R` rotated by a rotation vector in its own frame.
Quat Turn(const Quat& R, const Vec3& turn_rad);

}  // namespace kerf::reference
