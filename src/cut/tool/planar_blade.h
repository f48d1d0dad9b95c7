// What the flat blades with a row of teeth along one side have in common. Their drive moves them to and fro along the
// teeth.
#pragma once

#include <algorithm>
#include <optional>

#include "cut/tool/convex_outline.h"
#include "cut/tool/edge_motion.h"
#include "kerf/tool.h"

namespace kerf {

/// A plate in the x-y plane of T, with its teeth at +x and its back at -x. The teeth lie on a straight line along y
/// through the origin, or on an arc through the origin about the swing axis. Straight sides join the ends of the teeth
/// with those of the back.
struct PlanarBlade {
  using Point = ConvexOutline::Point;
  static constexpr int kChords = 8;

  double edge_mm = 0;          // length of the row of teeth, along it
  double swing_radius_mm = 0;  // from the swing axis to the teeth; 0: the edge is straight
  Point back_low;              // end of the back towards -y
  Point back_high;             // end of the back towards +y
  /// True: the end at +y is a tip, which cuts too, and the end at -y, at the handle, touches nothing. False: both ends
  /// are sides, which bone holds.
  bool has_tip = false;
  double thickness_mm = 0;
  double kerf_mm = 0;
  double pitch_mm = 0;
  double stroke_mm = 0;

  double teeth() const { return edge_mm / pitch_mm; }  // a real number
  double length_mm() const { return std::max(-back_low.x, -back_high.x); }
  EdgeMotion motion() const { return EdgeMotion(swing_radius_mm); }
  /// Returns the hull of the blade at all displacements of a range. An arc is replaced by kChords chords, whose corners
  /// lie on it, from its end at one end of the range to its other end at the other: a tooth in the middle stands out of
  /// it by at most CalcSagitta(). Tick-safe.
  ConvexOutline SweepOutline(const SlideRange& slide) const;
  double CalcSagitta() const;
  /// Distance of a point outwards from the edge that cuts, mm.
  double CalcEdgeDistance(const Point& p) const;
  /// Distance from the blade in the middle of its stroke, in its plane, with an exact arc; negative inside.
  double CalcSignedDistance(const Point& p) const;
  Point FindNearest(const Point& p) const;

 private:
  ConvexOutline MakeQuadrangle() const;
  bool IsInFrontOfArc(const Point& p) const;
};

/// Returns what a tool is as such a blade; nullopt for a tool that turns. Tick-safe.
std::optional<PlanarBlade> FindPlanarBlade(const Tool& tool);

}  // namespace kerf
