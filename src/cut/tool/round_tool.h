// What the kinds of tools of the form kRound share.
#pragma once

#include <functional>
#include <vector>

#include "cut/tool/round_solid.h"
#include "cut/tool/shape.h"

namespace kerf {

/// Throws kerf::Error if the tip leaves no side.
void CheckHeadLength(const RoundSolid& solid, double point_angle_deg);

/// Edges of a tool of the form kRound, treated as continuous along the flutes and around the axis.
struct RoundEdges {
  int flutes = 0;
  double tooth_width_mm = 0;
  double chisel_radius_mm = 0;  // teeth nearer to the axis count 1 + chisel_excess times; only of the end
  double chisel_excess = 0;
};
/// Returns points around the axis: of the side, if it cuts, then of the end. `passes_per_turn` is the number of flutes.
ToolShape MakeRoundShape(const RoundSolid& solid, const RoundEdges& edges, const ShapeSampling& sampling);
/// Returns slices of the solid about as thick as they are wide.
std::vector<CoverPlate> MakeRoundCover(const RoundSolid& solid);
/// As MakeToolSection().
std::vector<Vec3> MakeRoundSection(const RoundSolid& solid, const Pose& X_ST);
/// As SampleToolSurface().
std::vector<Vec3> SampleRoundSurface(const RoundSolid& solid, double step_mm);

/// Grooves between the flutes in a mesh.
struct FluteLooks {
  int flutes;
  double twist_rad_per_mm;
  double rings_per_mm;
  /// Depth of the groove, as a fraction of the radius, at a phase from 0 to 1 from one flute to the next.
  std::function<double(double phase)> depth;
};
/// Returns a closed mesh of the solid with its grooves, and the end of its shank.
TriangleMesh MakeRoundMesh(const RoundSolid& solid, const FluteLooks& looks);

}  // namespace kerf
