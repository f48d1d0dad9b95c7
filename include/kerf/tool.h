// The tools: a thin toothed disc on a spindle, and a ball burr.
#pragma once

#include <numbers>
#include <variant>

#include "kerf/geometry.h"

namespace kerf {

/// Circular saw. Tool frame T: origin at the disc's centre, z along the spindle axis, disc in the x-y plane. The
/// defaults are the disc for which the paper's tables were computed (docs/physics.md).
struct DiscSaw {
  double diameter_mm = 22;     // 1 to 200
  double thickness_mm = 0.25;  // 0.02 to 10; width of the kerf
  int teeth = 24;              // 1 to 1000
  double E_MPa = 205000;       // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 80};  // the hand's grip, frame T, each component -1000 to 1000; reference point of torques

  double radius_mm() const { return 0.5 * diameter_mm; }
  double pitch_mm() const { return std::numbers::pi * diameter_mm / teeth; }
  /// Throws kerf::Error naming the first value out of range.
  void Validate() const;
};

/// Ball burr: a sphere with cutting edges (flutes) from pole to pole. Tool frame T: origin at the ball's centre, z
/// along the spindle axis. A flute is modelled as a row of teeth of `tooth_width_mm`, the length of edge to which the
/// force law applies. This width is an assumption (docs/physics.md).
struct BallBurr {
  double diameter_mm = 6;       // 0.5 to 50
  int flutes = 8;               // 1 to 100
  double tooth_width_mm = 0.5;  // length of edge per tooth, 0.01 to 50
  double E_MPa = 205000;        // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 80};  // as DiscSaw::p_TG_mm

  double radius_mm() const { return 0.5 * diameter_mm; }
  /// Throws kerf::Error naming the first value out of range.
  void Validate() const;
};

/// Any tool.
using Tool = std::variant<DiscSaw, BallBurr>;

void Validate(const Tool& tool);            // throws kerf::Error naming the first value out of range
double CalcReach(const Tool& tool);         // radius of the smallest ball around the origin of T that contains the
                                            // tool, mm
double CalcThickness(const Tool& tool);     // of a disc, mm; 0 for a ball
double CalcModulus(const Tool& tool);       // E, MPa
double CalcPoissonRatio(const Tool& tool);  // nu
Vec3 CalcGrip(const Tool& tool);            // p_TG, mm

/// Dimensions of a tooth that the force laws need.
struct Tooth {
  double tool_radius_mm;  // radius of the sphere in the paper's Hertz contact; half the tool's diameter
  double pitch_mm;        // along the edge of the disc; between flutes at the equator of the ball
  double width_mm;        // of the cutting edge
};
Tooth CalcTooth(const Tool& tool);

}  // namespace kerf
