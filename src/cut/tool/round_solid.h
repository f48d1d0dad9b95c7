// Convex solid of revolution: the body of a bur.
#pragma once

#include <array>

#include "kerf/geometry.h"

namespace kerf {

/// Solid about the z axis with its tip at the origin: a conical or flat end, a cylindrical or conical side that does
/// not narrow upwards, and a flat top. Lengths in mm.
struct RoundSolid {
  double corner_radius_mm = 0;  // at the corner between end and side
  double corner_z_mm = 0;       // of the same corner; 0: the end is flat
  double top_radius_mm = 0;     // at least corner_radius_mm
  double top_z_mm = 0;
  bool side_cuts = true;  // false: only the end has cutting edges

  /// Cone, cylinder or plane r * radius + z * height <= offset_mm, with the distance from the z axis as the radius; the
  /// normal (r, z) has unit length, and r >= 0.
  struct Face {
    double r, z;
    double offset_mm;

    double CalcDistance(double radius_mm, double z_mm) const { return r * radius_mm + z * z_mm - offset_mm; }
  };
  /// End, side and top. The solid is where all three hold.
  std::array<Face, 3> CalcFaces() const;
  /// Largest ratio of the distance of a point outside to its largest distance from a face.
  double CalcCornerFactor() const;

  /// Both tick-safe.
  double CalcSignedDistance(const Vec3& p) const;
  /// Nearest point of the solid; the point itself inside.
  Vec3 FindNearest(const Vec3& p) const;
  /// Point of the part that cuts which lies furthest along a direction of any length; one of the axis if all around it
  /// do.
  Vec3 FindDeepest(const Vec3& n) const;
};

/// Returns the solid of a head that is `length_mm` long with its tip, `diameter_mm` wide at the top, and `taper` times
/// as wide above the tip.
RoundSolid MakeRoundSolid(double diameter_mm, double length_mm, double taper, double point_angle_deg);

}  // namespace kerf
