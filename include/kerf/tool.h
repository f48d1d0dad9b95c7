// The tools: a thin toothed disc on a spindle, a ball burr, a fissure bur, a twist drill, the blades of reciprocating
// and oscillating saws, the saw insert of a piezoelectric handpiece.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <variant>

#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf {

/// Largest speed of a spindle that a tick accepts, in either direction, and speeds that users may set.
inline constexpr double kMaxRpm = 1e6;
inline constexpr double kMinRpm = 1;  // a slower spindle is stopped
inline constexpr Range kSpindleRange_rpm{kMinRpm, kMaxRpm / 10, kOrZero};
/// Largest rate of a drive that vibrates, which a tick accepts for such a tool, and which users may set.
inline constexpr double kMaxStrokesPerMin = 3e6;

/// Circular saw. Tool frame T: origin at the disc's centre, z along the spindle axis, disc in the x-y plane. The
/// defaults are the disc for which the paper's tables were computed (docs/physics.md).
struct DiscSaw {
  double diameter_mm = 22;
  double thickness_mm = 0.25;
  int teeth = 24;
  double rake_deg = -10;      // of a tooth; the teeth of the measured saw blade (docs/physics.md)
  double edge_radius_um = 8;  // rounding of a tooth's edge; an assumption
  double E_MPa = 205000;      // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 80};

  double radius_mm() const { return 0.5 * diameter_mm; }
  double pitch_mm() const { return std::numbers::pi * diameter_mm / teeth; }
  /// Throws kerf::Error naming the first value out of range.
  void Validate() const;
};

/// Ball burr: a sphere with cutting edges (flutes) from pole to pole. Tool frame T: origin at the ball's centre, z
/// along the spindle axis, towards the handpiece. A flute is modelled as a row of teeth of `tooth_width_mm`, the length
/// of edge to which the force law applies. This width is an assumption (docs/physics.md).
struct BallBurr {
  double diameter_mm = 6;
  int flutes = 8;
  double tooth_width_mm = 0.5;
  double rake_deg = -10;      // as for a disc
  double edge_radius_um = 8;  // as for a disc
  double E_MPa = 205000;      // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 80};

  double radius_mm() const { return 0.5 * diameter_mm; }
  /// Throws kerf::Error naming the first value out of range.
  void Validate() const;
};

/// Fissure bur, or Lindemann bur: a cylinder or cone with cutting edges (flutes) along its side and across its end,
/// both of which cut. Tool frame T: origin at the tip, z along the spindle axis, towards the handpiece. Flutes are
/// modelled as those of a ball burr. The shank above the head is not modelled.
struct FissureBur {
  double diameter_mm = 1.6;  // ISO 016
  double length_mm = 8;
  double taper = 1;
  double point_angle_deg = 180;
  int flutes = 6;
  double tooth_width_mm = 0.5;
  double rake_deg = -10;      // as for a disc
  double edge_radius_um = 8;  // as for a disc
  double E_MPa = 205000;      // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 80};

  double radius_mm() const { return 0.5 * diameter_mm; }
  /// Throws kerf::Error naming the first value out of range, or if the tip is as long as the head.
  void Validate() const;
};

/// Twist drill: a cylinder with two straight cutting edges (lips) on its conical tip. Tool frame T: as for a fissure
/// bur. A lip is modelled as a row of teeth, as a flute of a ball burr; the teeth of the chisel edge between the lips
/// count several times (docs/tick.md). Not modelled: the spiral grooves, which carry the chips away, and friction of
/// the side.
struct TwistDrill {
  double diameter_mm = 1.5;
  double length_mm = 20;
  double point_angle_deg = 118;
  double tooth_width_mm = 0.5;
  double chisel_share = 0.45;
  double rake_deg = -10;      // as for a disc
  double edge_radius_um = 8;  // as for a disc
  double E_MPa = 205000;      // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 120};

  double radius_mm() const { return 0.5 * diameter_mm; }
  /// Throws kerf::Error naming the first value out of range, or if the tip is as long as the drill.
  void Validate() const;
};

/// Blade of a reciprocating saw, which a stroke moves to and fro along its straight toothed edge. Tool frame T: y along
/// the edge towards the tip, x the feed direction, z across the blade. The origin is at the middle of the edge where
/// the blade is in the middle of its stroke: the blade reaches from -length_mm / 2 to length_mm / 2 along y, and back
/// to -width_mm along x. The frame T does not move with the stroke.
struct ReciprocatingBlade {
  double length_mm = 30;
  double width_mm = 6;
  double taper = 1;
  double thickness_mm = 0.4;
  double set_mm = 0.05;
  double pitch_mm = 1.41;  // 18 teeth an inch
  double stroke_mm = 3;
  double rake_deg = -10;      // as for a disc
  double edge_radius_um = 8;  // as for a disc
  double E_MPa = 205000;      // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, -100, 0};

  double kerf_mm() const { return thickness_mm + 2 * set_mm; }
  double teeth() const { return length_mm / pitch_mm; }  // a real number
  /// Throws kerf::Error naming the first value out of range.
  void Validate() const;
};

/// Blade of an oscillating (sagittal) saw, which swings to and fro about an axis behind the toothed arc at its end.
/// Tool frame T: x the feed direction, y along the edge, z across the blade. The origin is at the middle of the arc
/// where the blade is in the middle of its swing; the swing axis is parallel to z through (-radius_mm, 0). Straight
/// sides lead from the arc to the axis, where the blade ends; the handpiece behind it is not modelled. The frame T does
/// not swing.
struct OscillatingBlade {
  double radius_mm = 25;
  double width_mm = 9;
  double taper = 0.6;
  double thickness_mm = 0.4;
  double set_mm = 0.05;
  double pitch_mm = 1;
  double swing_deg = 5;
  double rake_deg = -10;      // as for a disc
  double edge_radius_um = 8;  // as for a disc
  double E_MPa = 205000;      // steel
  double nu = 0.28;
  Vec3 p_TG_mm{-100, 0, 0};

  double kerf_mm() const { return thickness_mm + 2 * set_mm; }
  double edge_mm() const { return 2 * radius_mm * std::asin(0.5 * width_mm / radius_mm); }  // length of the arc
  double stroke_mm() const { return swing_deg * (std::numbers::pi / 180) * radius_mm; }     // along the arc
  double teeth() const { return edge_mm() / pitch_mm; }                                     // a real number
  /// Throws kerf::Error naming the first value out of range, or if the toothed end is wider than 1.2 radii.
  void Validate() const;
};

/// Saw insert of a piezoelectric handpiece, whose straight toothed end vibrates along its teeth. Tool frame T: as for
/// an oscillating blade, with a straight edge; the insert reaches back to -length_mm along x.
struct PiezoInsert {
  double length_mm = 10;
  double width_mm = 4;
  double taper = 0.9;
  double thickness_mm = 0.5;
  double set_mm = 0;
  double pitch_mm = 0.8;
  double stroke_mm = 0.12;
  double rake_deg = -10;      // as for a disc
  double edge_radius_um = 8;  // as for a disc
  double E_MPa = 205000;      // steel
  double nu = 0.28;
  Vec3 p_TG_mm{-80, 0, 0};

  double kerf_mm() const { return thickness_mm + 2 * set_mm; }
  double teeth() const { return width_mm / pitch_mm; }  // a real number
  /// Throws kerf::Error naming the first value out of range.
  void Validate() const;
};

/// Shapes; [tool] of a scene has the same keys.
template <typename V>
void DescribeShape(DiscSaw& p, V&& visit) {
  visit("diameter_mm", p.diameter_mm, Range{1, 200}, "diameter of the disc over the teeth");
  visit("thickness_mm", p.thickness_mm, Range{0.02, 10}, "thickness of the disc: the width of the kerf");
  visit("teeth", p.teeth, Range{1, 1000}, "number of teeth, evenly spaced on the rim");
}
template <typename V>
void DescribeShape(BallBurr& p, V&& visit) {
  visit("diameter_mm", p.diameter_mm, Range{0.5, 50}, "diameter of the ball");
  visit("flutes", p.flutes, Range{1, 100}, "number of cutting edges, each from pole to pole");
  visit("tooth_width_mm", p.tooth_width_mm, Range{0.01, 50},
        "length of a flute's edge that counts as one tooth in the force law; an assumption");
}
template <typename V>
void DescribeShape(FissureBur& p, V&& visit) {
  visit("diameter_mm", p.diameter_mm, Range{0.3, 20}, "diameter of the head, at its widest");
  visit("length_mm", p.length_mm, Range{0.5, 60}, "length of the head that cuts, with its tip");
  visit("taper", p.taper, Range{0.1, 1},
        "width of the head above its tip, as a fraction of diameter_mm; 1: a cylinder");
  visit("point_angle_deg", p.point_angle_deg, Range{60, 180}, "full angle of the tip; 180: the end is flat");
  visit("flutes", p.flutes, Range{1, 100}, "number of cutting edges, each along the side and across the end");
  visit("tooth_width_mm", p.tooth_width_mm, Range{0.01, 50},
        "length of a flute's edge that counts as one tooth in the force law; an assumption");
}
template <typename V>
void DescribeShape(TwistDrill& p, V&& visit) {
  visit("diameter_mm", p.diameter_mm, Range{0.3, 20}, "diameter of the drill: that of the hole");
  visit("length_mm", p.length_mm, Range{0.5, 100}, "length of the drill's cylinder with its tip");
  visit("point_angle_deg", p.point_angle_deg, Range{60, 180}, "full angle of the tip");
  visit("tooth_width_mm", p.tooth_width_mm, Range{0.01, 50},
        "length of a lip that counts as one tooth in the force law; an assumption");
  visit("chisel_share", p.chisel_share, Range{0, 0.8},
        "fraction of the thrust in whole bone that comes from the chisel edge between the lips (Saha et al. 1982); 0: "
        "split point, or none");
}
template <typename V>
void DescribeShape(ReciprocatingBlade& p, V&& visit) {
  visit("length_mm", p.length_mm, Range{3, 200}, "length of the toothed edge");
  visit("width_mm", p.width_mm, Range{1, 50}, "distance from the toothed edge to the back, at the handle's end");
  visit("taper", p.taper, Range{0.1, 1}, "width at the tip as a fraction of width_mm");
  visit("thickness_mm", p.thickness_mm, Range{0.02, 10}, "thickness of the blade without the set of its teeth");
  visit("set_mm", p.set_mm, Range{0, 2}, "distance by which the teeth stand out on each side; they widen the kerf");
  visit("pitch_mm", p.pitch_mm, Range{0.1, 20}, "distance between neighbouring teeth");
  visit("stroke_mm", p.stroke_mm, Range{0.05, 30}, "way of the blade from one end of the stroke to the other");
}
template <typename V>
void DescribeShape(OscillatingBlade& p, V&& visit) {
  visit("radius_mm", p.radius_mm, Range{8, 100}, "distance from the swing axis to the teeth");
  visit("width_mm", p.width_mm, Range{1, 30}, "width of the toothed end: the chord of its arc");
  visit("taper", p.taper, Range{0.1, 1}, "width at the swing axis as a fraction of width_mm");
  visit("thickness_mm", p.thickness_mm, Range{0.02, 10}, "thickness of the blade without the set of its teeth");
  visit("set_mm", p.set_mm, Range{0, 2}, "distance by which the teeth stand out on each side; they widen the kerf");
  visit("pitch_mm", p.pitch_mm, Range{0.1, 20}, "distance between neighbouring teeth along the arc");
  visit("swing_deg", p.swing_deg, Range{0.1, 20}, "angle of the blade from one end of the swing to the other");
}
template <typename V>
void DescribeShape(PiezoInsert& p, V&& visit) {
  visit("length_mm", p.length_mm, Range{1, 50}, "distance from the toothed end to the back");
  visit("width_mm", p.width_mm, Range{0.5, 20}, "width of the toothed end");
  visit("taper", p.taper, Range{0.1, 1}, "width at the back as a fraction of width_mm");
  visit("thickness_mm", p.thickness_mm, Range{0.02, 10}, "thickness of the insert without the set of its teeth");
  visit("set_mm", p.set_mm, Range{0, 2}, "distance by which the teeth stand out on each side; they widen the kerf");
  visit("pitch_mm", p.pitch_mm, Range{0.1, 20}, "distance between neighbouring teeth");
  visit("stroke_mm", p.stroke_mm, Range{0.01, 0.5}, "way of the teeth from one end of the vibration to the other");
}
/// Shape of a tooth's edge, which all tools have. Only some force laws read the radius; none reads the rake.
template <typename AnyTool, typename V>
void DescribeEdge(AnyTool& p, V&& visit) {
  visit("rake_deg", p.rake_deg, Range{-60, 45},
        "rake angle of a tooth; the force laws do not read it, they state the rake for which they were measured");
  visit("edge_radius_um", p.edge_radius_um, Range{0, 1000},
        "radius of a tooth's rounded edge; an assumption, read by two_component for bites below it");
}
/// What all tools have. A scene gives E in GPa.
template <typename V>
void DescribeSteel(const char* E_key, double& E, double E_per_GPa, double& nu, Vec3& p_TG_mm, V&& visit) {
  visit(E_key, E, E_per_GPa * Range{1, 1500}, "Young's modulus of the tool's steel");
  visit("nu", nu, kPoissonRatioRange, "Poisson's ratio of the tool's steel");
  visit("grip_mm", p_TG_mm, Range{-1000, 1000},
        "point at which the hand grips the tool, tool frame (z: spindle, x: feed); torques are about this point");
}
template <typename AnyTool, typename V>
requires requires(AnyTool& p) {
  p.p_TG_mm;
  p.rake_deg;
}
void Describe(AnyTool& p, V&& visit) {
  DescribeShape(p, visit);
  DescribeEdge(p, visit);
  DescribeSteel("E_MPa", p.E_MPa, 1000, p.nu, p.p_TG_mm, visit);
}

/// Any tool. A kind of tool is a struct of parameters here and the parts that kerf needs of it in its own file of
/// src/cut/tool (tool_kind.h).
using Tool = std::variant<DiscSaw, BallBurr, FissureBur, TwistDrill, ReciprocatingBlade, OscillatingBlade, PiezoInsert>;

/// Form of a tool. Kinds of the same form share contact, guides and measures.
enum class ToolForm {
  kBlade,  // flat, in the x-y plane of T: its edge cuts; its two flats do not, and the walls of the kerf hold them
  kBall,   // a sphere about the origin of T, whose whole surface cuts
  kRound,  // a convex solid of revolution about the z axis of T with its tip at the origin: its end cuts, and its side
           // cuts too, or is held by the wall of the hole
};
ToolForm GetForm(const Tool& tool);
inline bool IsBlade(const Tool& tool) {
  return GetForm(tool) == ToolForm::kBlade;
}

/// How a tool's edge moves in the tool frame.
enum class DriveMotion {
  kRotation,  // about z of T: a disc with rpm > 0, others with rpm < 0, clockwise as seen from the handpiece
  kStroke,    // to and fro along itself: along y of T, or about a swing axis behind it (CalcSwingRadius()); `rpm` is
              // then the number of double strokes or swings a minute
};
DriveMotion GetDrive(const Tool& tool);

void Validate(const Tool& tool);                    // throws kerf::Error naming the first value out of range
std::string DescribeTool(const Tool& tool);         // such as "disc 22 x 0.25 mm, 24 teeth"
std::string DescribeToolBriefly(const Tool& tool);  // such as "22 mm disc with 24 teeth"
double CalcReach(const Tool& tool);      // radius of the smallest ball around the origin of T that contains the
                                         // tool, mm
double CalcRadius(const Tool& tool);     // largest distance of the edge from the spindle axis, mm
double CalcThickness(const Tool& tool);  // of a blade, mm; 0 for any other tool
double CalcStroke(const Tool& tool);     // way of the edge from end to end of its stroke, mm; 0: it turns
double CalcCutWidth(const Tool& tool);   // of the groove that the tool cuts: a blade's kerf, another's diameter
double CalcSwingRadius(
    const Tool& tool);                  // from the swing axis to the edge, mm; 0: it turns, or its stroke is straight
Range CalcRateRange(const Tool& tool);  // speeds that users may set as `rpm`
double CalcOrdinaryRate(const Tool& tool);  // an ordinary speed of this kind of tool, in the terms of `rpm`
int CountPassesPerTurn(const Tool& tool);   // teeth that pass a point of the edge in a turn of the spindle;
                                            // for a stroke: in a double stroke, rounded
double CalcModulus(const Tool& tool);       // E, MPa
double CalcPoissonRatio(const Tool& tool);  // nu
double CalcRake(const Tool& tool);          // of a tooth, degrees
Vec3 CalcGrip(const Tool& tool);            // p_TG, mm

/// Dimensions of a tooth that the force laws need.
struct Tooth {
  double tool_radius_mm;  // radius of the sphere in the paper's Hertz contact; half the tool's diameter
  double pitch_mm;        // along the edge of the disc; between flutes where the others are widest
  double width_mm;        // of the cutting edge
  double rake_deg;
  double edge_radius_mm;
};
Tooth CalcTooth(const Tool& tool);

}  // namespace kerf
