// Where circles of the disc have bone before them, and how much of it they take.
#pragma once

#include <functional>
#include <vector>

#include "experiment/reference/exact_bone.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf::reference {

inline constexpr double kPi = 3.14159265358979323846;

/// A piece of a circle about the spindle with bone of one region before all of it. Angles from the tool's x towards its
/// y; the reduced modulus at both ends.
struct Piece {
  double from_rad = 0, to_rad = 0;
  double E_star_from_MPa = 0, E_star_to_MPa = 0;

  double E_star_MPa(double angle_rad) const {
    const double t = to_rad > from_rad ? (angle_rad - from_rad) / (to_rad - from_rad) : 0;
    return (1 - t) * E_star_from_MPa + t * E_star_to_MPa;
  }
};

/// Of Hertz's contact: the bone at the point and the tool's steel as two compliances in series; 0 where there is no
/// material.
double CalcEStar(const ExactSolid::Material& bone, const DiscSaw& saw);

/// What to look for.
struct Circle {
  double radius_mm = 0;
  double z_mm = 0;
  bool with_material = false;  // else bone is bone
};

/// The pieces of the circle between two angles that are in the bone: looked at in about 2 pi / `points` of the circle,
/// the ends between two looks by bisection to 1e-8 rad.
void FindPieces(const ExactBone& bone, const DiscSaw& saw, const Pose& X_WT, const Circle& circle, double from_rad,
                double to_rad, int points, std::vector<Piece>& pieces);

/// Volume per second that the disc takes from the bone, mm^3/s: uncut bone at the disc's surface times the speed at
/// which that moves outwards. `X_WT`: half-way on the step, with the bone as it was at the step's start.
class Flux {
 public:
  /// `flats`: these take too.
  Flux(const DiscSaw& saw, int rim_points, double flat_spacing_mm, bool flats);
  /// Velocity of the tool's origin and turning rate, in the tool's frame.
  double Calc(const ExactBone& bone, const Pose& X_WT, const Vec3& v_T_mm_per_s, const Vec3& w_T_rad_per_s) const;

 private:
  double CalcRim(const ExactBone& bone, const Pose& X_WT, const Vec3& v, const Vec3& w) const;
  double CalcFlats(const ExactBone& bone, const Pose& X_WT, const Vec3& v, const Vec3& w) const;

  DiscSaw saw_;
  int rim_points_;
  double flat_spacing_mm_;
  bool flats_;
};

// ---- poses between poses
/// At `share` of the way from a to b: straight, and evenly turning.
Pose Between(const Pose& X_a, const Pose& X_b, double share);
/// The rotation vector that takes `R_a` to `R_b`, in the frame of a, rad.
Vec3 TurnBetween(const Quat& R_a, const Quat& R_b);
/// `R` turned by a rotation vector of its own frame.
Quat Turn(const Quat& R, const Vec3& turn_rad);

}  // namespace kerf::reference
