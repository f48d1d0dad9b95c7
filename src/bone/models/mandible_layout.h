// Positions of the parts of the generic mandible, left half, derived once from its parameters.
#pragma once

#include "bone/models/mandible.h"
#include "bone/models/plane_curve.h"

namespace kerf {

/// Positions along the body, named after the teeth above them: mm along the dental arch from the midline.
struct ArchPlaces {
  double canine = 0, mental_foramen = 0, first_molar = 0, second_molar = 0, third_molar = 0;
};

struct MandibleLayout {
  MandibleParams params;
  PlaneCurve base;    // middle of the body, seen from above
  PlaneCurve dental;  // middle of the tooth row
  ArchPlaces on_dental;
  ArchPlaces on_base;

  // Side view (y-z plane): the base line from menton to gonion, and the axes of the ramus at gonion.
  double base_slope = 0;  // of the base line against the occlusal plane, radians
  Vec2 menton_yz{0};
  Vec2 gonion_yz{0};
  Vec2 u_yz{0};  // unit, forward, across the back edge of the ramus
  Vec2 v_yz{0};  // unit, up along it

  /// Returns z of the base line at y.
  double BaseLineZ(double y) const { return menton_yz.y + std::tan(base_slope) * (y - menton_yz.x); }
  /// Returns (u, v) of a point in the side view.
  Vec2 ToRamus(double y, double z) const {
    const Vec2 d = Vec2{y, z} - gonion_yz;
    return {glm::dot(d, u_yz), glm::dot(d, v_yz)};
  }
  Vec2 FromRamus(const Vec2& uv) const { return gonion_yz + uv.x * u_yz + uv.y * v_yz; }
  /// Returns v of the point with this u that is `height` mm above the base line.
  double RamusV(double u, double height) const;
  /// Returns x of the middle of the ramus's thickness.
  double RamusX(double u, double v) const;
};

MandibleLayout MakeMandibleLayout(const MandibleParams& params);

}  // namespace kerf
