#include "cut/tool/fissure_bur.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cut/tool/round_tool.h"
#include "kerf/error.h"

namespace kerf {

RoundSolid MakeBurSolid(const FissureBur& bur) {
  return MakeRoundSolid(bur.diameter_mm, bur.length_mm, bur.taper, bur.point_angle_deg);
}

void FissureBur::Validate() const {
  CheckParameters(*this);
  CheckHeadLength(MakeBurSolid(*this), point_angle_deg);
}

std::string ToolKind<FissureBur>::Name(const FissureBur& bur) {
  std::string name = fmt::format("bur {:g} x {:g} mm, {} flutes", bur.diameter_mm, bur.length_mm, bur.flutes);
  if (bur.taper < 1) name += fmt::format(", taper {:g}", bur.taper);
  if (bur.point_angle_deg < 180) name += fmt::format(", point {:g} degrees", bur.point_angle_deg);
  return name;
}

std::string ToolKind<FissureBur>::ShortName(const FissureBur& bur) {
  return fmt::format("{:g} mm bur", bur.diameter_mm);
}

std::optional<RoundSolid> ToolKind<FissureBur>::CalcRoundSolid(const FissureBur& bur) {
  return MakeBurSolid(bur);
}

double ToolKind<FissureBur>::CalcReach(const FissureBur& bur) {
  return std::hypot(bur.radius_mm(), bur.length_mm);
}

Tooth ToolKind<FissureBur>::CalcTooth(const FissureBur& bur) {
  return {bur.radius_mm(), 2 * std::numbers::pi * bur.radius_mm() / bur.flutes, bur.tooth_width_mm, bur.rake_deg,
          1e-3 * bur.edge_radius_um};
}

Vec3 ToolKind<FissureBur>::FindNearest(const FissureBur& bur, const Vec3& p_T) {
  return MakeBurSolid(bur).FindNearest(p_T);
}

double ToolKind<FissureBur>::CalcSignedDistance(const FissureBur& bur, const Vec3& p_T) {
  return MakeBurSolid(bur).CalcSignedDistance(p_T);
}

Vec3 ToolKind<FissureBur>::FindDeepest(const FissureBur& bur, const Vec3& n_T) {
  return MakeBurSolid(bur).FindDeepest(n_T);
}

ToolShape ToolKind<FissureBur>::MakeShape(const FissureBur& bur, const ShapeSampling& sampling) {
  return MakeRoundShape(MakeBurSolid(bur), {bur.flutes, bur.tooth_width_mm}, sampling);
}

std::vector<CoverPlate> ToolKind<FissureBur>::MakeCover(const FissureBur& bur) {
  return MakeRoundCover(MakeBurSolid(bur));
}

ToolLooks ToolKind<FissureBur>::MakeLooks(const FissureBur& bur) {
  constexpr double kGroove = 0.16;
  ToolLooks looks;
  // A sharp edge in front with a slope behind it.
  looks.whole = MakeRoundMesh(MakeBurSolid(bur), {bur.flutes, 0.1, 4, [](double phase) { return kGroove * phase; }});
  return looks;
}

std::vector<Vec3> ToolKind<FissureBur>::MakeSection(const FissureBur& bur, const Pose& X_ST, double) {
  return MakeRoundSection(MakeBurSolid(bur), X_ST);
}

std::vector<Vec3> ToolKind<FissureBur>::SampleSurface(const FissureBur& bur, double step_mm) {
  return SampleRoundSurface(MakeBurSolid(bur), step_mm);
}

}  // namespace kerf
