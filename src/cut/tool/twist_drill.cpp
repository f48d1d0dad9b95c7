#include "cut/tool/twist_drill.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cut/tool/round_tool.h"
#include "kerf/error.h"

namespace kerf {

RoundSolid MakeDrillSolid(const TwistDrill& drill) {
  RoundSolid solid = MakeRoundSolid(drill.diameter_mm, drill.length_mm, 1, drill.point_angle_deg);
  solid.side_cuts = false;
  return solid;
}

void TwistDrill::Validate() const {
  CheckParameters(*this);
  CheckHeadLength(MakeDrillSolid(*this), point_angle_deg);
}

std::string ToolKind<TwistDrill>::Name(const TwistDrill& drill) {
  return fmt::format("drill {:g} x {:g} mm, point {:g} degrees", drill.diameter_mm, drill.length_mm,
                     drill.point_angle_deg);
}

std::string ToolKind<TwistDrill>::ShortName(const TwistDrill& drill) {
  return fmt::format("{:g} mm drill", drill.diameter_mm);
}

std::optional<RoundSolid> ToolKind<TwistDrill>::CalcRoundSolid(const TwistDrill& drill) {
  return MakeDrillSolid(drill);
}

double ToolKind<TwistDrill>::CalcReach(const TwistDrill& drill) {
  return std::hypot(drill.radius_mm(), drill.length_mm);
}

Tooth ToolKind<TwistDrill>::CalcTooth(const TwistDrill& drill) {
  return {drill.radius_mm(), 2 * std::numbers::pi * drill.radius_mm() / kLips, drill.tooth_width_mm, drill.rake_deg,
          1e-3 * drill.edge_radius_um};
}

Vec3 ToolKind<TwistDrill>::FindNearest(const TwistDrill& drill, const Vec3& p_T) {
  return MakeDrillSolid(drill).FindNearest(p_T);
}

double ToolKind<TwistDrill>::CalcSignedDistance(const TwistDrill& drill, const Vec3& p_T) {
  return MakeDrillSolid(drill).CalcSignedDistance(p_T);
}

Vec3 ToolKind<TwistDrill>::FindDeepest(const TwistDrill& drill, const Vec3& n_T) {
  return MakeDrillSolid(drill).FindDeepest(n_T);
}

ToolShape ToolKind<TwistDrill>::MakeShape(const TwistDrill& drill, const ShapeSampling& sampling) {
  return MakeRoundShape(
      MakeDrillSolid(drill),
      {kLips, drill.tooth_width_mm, kChiselRadius * drill.radius_mm(), CalcChiselThrust(drill) / kChiselRadius},
      sampling);
}

std::vector<CoverPlate> ToolKind<TwistDrill>::MakeCover(const TwistDrill& drill) {
  return MakeRoundCover(MakeDrillSolid(drill));
}

ToolLooks ToolKind<TwistDrill>::MakeLooks(const TwistDrill& drill) {
  constexpr double kGroove = 0.55;
  constexpr double kHelix = 0.45;  // tangent of the helix angle
  const double twist_rad_per_mm = kHelix / drill.radius_mm();
  ToolLooks looks;
  // A land of a fifth of the way to the other lip, then a round groove.
  looks.whole = MakeRoundMesh(MakeDrillSolid(drill), {kLips, twist_rad_per_mm, 8 * twist_rad_per_mm, [](double phase) {
                                                        const double in = std::max(0.0, (phase - 0.2) / 0.8);
                                                        return kGroove * std::sin(std::numbers::pi * in);
                                                      }});
  return looks;
}

std::vector<Vec3> ToolKind<TwistDrill>::MakeSection(const TwistDrill& drill, const Pose& X_ST, double) {
  return MakeRoundSection(MakeDrillSolid(drill), X_ST);
}

std::vector<Vec3> ToolKind<TwistDrill>::SampleSurface(const TwistDrill& drill, double step_mm) {
  return SampleRoundSurface(MakeDrillSolid(drill), step_mm);
}

}  // namespace kerf
