// The tools: a thin toothed disc on a spindle, and a ball burr.
#pragma once

#include <variant>

#include "kerf/geometry.h"

namespace kerf {

/// A circular saw. Tool frame T: origin at the disc's centre, z along the spindle axis, disc in the x-y plane.
/// Defaults are the disc that the paper's tables were computed with (docs/physics.md).
struct DiscSaw {
  double diameter_mm = 22;     // 1 to 200
  double thickness_mm = 0.25;  // 0.02 to 10; the kerf's width
  int teeth = 24;              // 1 to 1000
  double E_MPa = 205000;       // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 80};  // the hand's grip in T; torques are about it

  double radius_mm() const { return 0.5 * diameter_mm; }
  double pitch_mm() const { return 3.14159265358979323846 * diameter_mm / teeth; }
  /// Throws Error naming the first value out of range.
  void Validate() const;
};

/// A ball burr: a sphere with cutting edges (flutes) from pole to pole. Tool frame T: origin at the ball's centre, z
/// along the spindle axis. A flute is a row of teeth, each the stretch of edge that the force law is given for; how
/// long that is is an assumption (docs/physics.md).
struct BallBurr {
  double diameter_mm = 6;       // 0.5 to 50
  int flutes = 8;               // 1 to 100
  double tooth_width_mm = 0.5;  // of a flute's edge, 0.01 to 50
  double E_MPa = 205000;        // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 80};  // as the saw's

  double radius_mm() const { return 0.5 * diameter_mm; }
  /// Throws Error naming the first value out of range.
  void Validate() const;
};

/// What cuts.
using Tool = std::variant<DiscSaw, BallBurr>;

void Validate(const Tool& tool);            // throws Error naming the first value out of range
double CalcReach(const Tool& tool);         // radius of the smallest ball about the origin of T that holds the tool, mm
double CalcModulus(const Tool& tool);       // E, MPa
double CalcPoissonRatio(const Tool& tool);  // nu
Vec3 CalcGrip(const Tool& tool);            // p_TG, mm

/// What the force laws need of a tool's teeth.
struct Tooth {
  double tool_radius_mm;  // the paper's sphere of Hertz; half the tool's diameter
  double pitch_mm;        // along the edge of the disc; between flutes at the equator of the ball
  double width_mm;        // of its cutting edge
};
Tooth CalcTooth(const Tool& tool);

}  // namespace kerf
