// The parts of ToolKind that are the same for all flat blades with a row of teeth along one side.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "cut/tool/planar_blade.h"
#include "cut/tool/tool_kind.h"

namespace kerf {

/// Returns the distance of the ends of the edge from the origin.
double CalcPlanarRadius(const PlanarBlade& blade);
double CalcPlanarReach(const PlanarBlade& blade);
int CountPlanarPasses(const PlanarBlade& blade);
/// Returns 3 E I / L^3 with I = width thickness^3 / 12: of a cantilever plate, for a force at its end.
double CalcPlateStiffness(double E_MPa, double width_mm, double thickness_mm, double length_mm);
Vec3 FindPlanarDeepest(const PlanarBlade& blade, const Vec3& n_T);
ToolShape MakePlanarShape(const PlanarBlade& blade, const ShapeSampling& sampling);
/// A row of plates over the blade and all of its stroke.
std::vector<CoverPlate> MakePlanarCover(const PlanarBlade& blade);
ToolLooks MakePlanarLooks(const PlanarBlade& blade);
std::vector<Vec3> MakePlanarSection(const PlanarBlade& blade, const Pose& X_ST, double least_mm);
std::vector<Vec3> SamplePlanarSurface(const PlanarBlade& blade, double step_mm);

/// A kind of such blades derives from this and gives the other parts, with Make(), which returns what the blade is.
template <typename T>
struct PlanarToolKind {
  using Kind = ToolKind<T>;
  static constexpr ToolForm kForm = ToolForm::kBlade;
  static constexpr ToolWords kWords{"", "edge"};
  static constexpr DriveMotion kDrive = DriveMotion::kStroke;
  static double CalcStroke(const T& tool) { return Kind::Make(tool).stroke_mm; }
  static double CalcSwingRadius(const T& tool) { return Kind::Make(tool).swing_radius_mm; }
  static double CalcReach(const T& tool) { return CalcPlanarReach(Kind::Make(tool)); }
  static double CalcRadius(const T& tool) { return CalcPlanarRadius(Kind::Make(tool)); }
  static double CalcCutWidth(const T& tool) { return tool.kerf_mm(); }
  static int CountPassesPerTurn(const T& tool) { return CountPlanarPasses(Kind::Make(tool)); }
  /// A straight edge has no radius; half the length of the edge stands for it in Hertz's laws.
  static Tooth CalcTooth(const T& tool) {
    const PlanarBlade blade = Kind::Make(tool);
    return {blade.swing_radius_mm > 0 ? blade.swing_radius_mm : 0.5 * blade.edge_mm, tool.pitch_mm, tool.thickness_mm,
            tool.rake_deg, 1e-3 * tool.edge_radius_um};
  }
  static std::optional<RoundSolid> CalcRoundSolid(const T&) { return {}; }
  static Vec3 FindNearest(const T& tool, const Vec3& p_T) {
    const ConvexOutline::Point nearest = Kind::Make(tool).FindNearest({p_T.x, p_T.y});
    const double half_mm = 0.5 * tool.thickness_mm;
    return {nearest.x, nearest.y, std::clamp(p_T.z, -half_mm, half_mm)};
  }
  static double CalcSignedDistance(const T& tool, const Vec3& p_T) {
    const double out = Kind::Make(tool).CalcSignedDistance({p_T.x, p_T.y});
    const double across = std::abs(p_T.z) - 0.5 * tool.thickness_mm;
    return out > 0 && across > 0 ? std::hypot(out, across) : std::max(out, across);
  }
  static Vec3 FindDeepest(const T& tool, const Vec3& n_T) { return FindPlanarDeepest(Kind::Make(tool), n_T); }
  static ToolShape MakeShape(const T& tool, const ShapeSampling& sampling) {
    return MakePlanarShape(Kind::Make(tool), sampling);
  }
  static std::vector<CoverPlate> MakeCover(const T& tool) { return MakePlanarCover(Kind::Make(tool)); }
  static ToolLooks MakeLooks(const T& tool) { return MakePlanarLooks(Kind::Make(tool)); }
  static std::vector<Vec3> MakeSection(const T& tool, const Pose& X_ST, double least_mm) {
    return MakePlanarSection(Kind::Make(tool), X_ST, least_mm);
  }
  static std::vector<Vec3> SampleSurface(const T& tool, double step_mm) {
    return SamplePlanarSurface(Kind::Make(tool), step_mm);
  }
};

}  // namespace kerf
