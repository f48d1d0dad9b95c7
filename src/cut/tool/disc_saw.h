// The disc saw: a flat cylinder whose rim cuts.
#pragma once

#include "cut/tool/tool_kind.h"

namespace kerf {

template <>
struct ToolKind<DiscSaw> {
  static constexpr std::string_view kShape = "disc";
  static constexpr std::string_view kSummary = "a saw that cuts with its rim";
  static constexpr std::string_view kClass = "Disc";
  static constexpr std::string_view kFrame = "origin at the disc's centre, z along the spindle, towards the handpiece";
  static constexpr ToolForm kForm = ToolForm::kBlade;
  static constexpr ToolWords kWords{"", "rim"};
  static constexpr DriveMotion kDrive = DriveMotion::kRotation;
  static constexpr int kSense = 1;
  static constexpr double kOrdinaryRate_per_min = 7500;
  static std::string Name(const DiscSaw& disc);
  static std::string ShortName(const DiscSaw& disc);
  static double CalcReach(const DiscSaw& disc);
  static double CalcRadius(const DiscSaw& disc) { return disc.radius_mm(); }
  static double CalcCutWidth(const DiscSaw& disc) { return disc.thickness_mm; }
  static int CountPassesPerTurn(const DiscSaw& disc) { return disc.teeth; }
  static Tooth CalcTooth(const DiscSaw& disc);
  /// Bending of a plate about a flange, about 0.45 E t^3 / R^2; an estimate with an error of some tens of percent.
  static double CalcSideStiffness(const DiscSaw& disc);
  static std::optional<RoundSolid> CalcRoundSolid(const DiscSaw&) { return {}; }
  static Vec3 FindNearest(const DiscSaw& disc, const Vec3& p_T);
  static double CalcSignedDistance(const DiscSaw& disc, const Vec3& p_T);
  static Vec3 FindDeepest(const DiscSaw& disc, const Vec3& n_T);
  static ToolShape MakeShape(const DiscSaw& disc, const ShapeSampling& sampling);
  /// One plate in the middle, and 6, 12 and 18 in rings around it, each with a radius of less than a quarter of the
  /// disc's.
  static std::vector<CoverPlate> MakeCover(const DiscSaw& disc);
  static ToolLooks MakeLooks(const DiscSaw& disc);
  static std::vector<Vec3> MakeSection(const DiscSaw& disc, const Pose& X_ST, double least_mm);
  static std::vector<Vec3> SampleSurface(const DiscSaw& disc, double step_mm);
};

/// A flange on each side of a disc. Its size is an assumption.
struct DiscHub {
  double radius_mm;
  double outer_z_mm;  // of its outer face
};
DiscHub CalcHub(const DiscSaw& disc);

}  // namespace kerf
