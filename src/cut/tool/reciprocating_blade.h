// The blade of a reciprocating saw: a flat plate with teeth on one long side.
#pragma once

#include "cut/tool/tool_kind.h"

namespace kerf {

template <>
struct ToolKind<ReciprocatingBlade> {
  static constexpr std::string_view kShape = "reciprocating";
  static constexpr std::string_view kSummary = "a blade that a stroke moves along its straight toothed edge";
  static constexpr std::string_view kClass = "ReciprocatingBlade";
  static constexpr std::string_view kFrame =
      "origin at the middle of the toothed edge in the middle of the stroke, y along the edge towards the tip, x the "
      "feed "
      "direction, z across the blade";
  static constexpr ToolForm kForm = ToolForm::kBlade;
  static constexpr DriveMotion kDrive = DriveMotion::kStroke;
  static double CalcStroke(const ReciprocatingBlade& blade) { return blade.stroke_mm; }
  static ConvexOutline MakeOutline(const ReciprocatingBlade& blade);
  static std::string Name(const ReciprocatingBlade& blade);
  static std::string ShortName(const ReciprocatingBlade& blade);
  /// Of the blade at either end of its stroke.
  static double CalcReach(const ReciprocatingBlade& blade);
  static double CalcRadius(const ReciprocatingBlade& blade) { return 0.5 * blade.length_mm; }
  static double CalcCutWidth(const ReciprocatingBlade& blade) { return blade.kerf_mm(); }
  static int CountPassesPerTurn(const ReciprocatingBlade& blade);
  /// A straight edge has no radius; half the length of the edge stands for it in Hertz's laws.
  static Tooth CalcTooth(const ReciprocatingBlade& blade);
  /// Bending of a cantilever plate, 3 E I / L^3 with I = width thickness^3 / 12, for a force at the tip.
  static double CalcSideStiffness(const ReciprocatingBlade& blade);
  static std::optional<RoundSolid> CalcRoundSolid(const ReciprocatingBlade&) { return {}; }
  static Vec3 FindNearest(const ReciprocatingBlade& blade, const Vec3& p_T);
  static double CalcSignedDistance(const ReciprocatingBlade& blade, const Vec3& p_T);
  static Vec3 FindDeepest(const ReciprocatingBlade& blade, const Vec3& n_T);
  static ToolShape MakeShape(const ReciprocatingBlade& blade, const ShapeSampling& sampling);
  /// A row of plates over the blade and all of its stroke.
  static std::vector<CoverPlate> MakeCover(const ReciprocatingBlade& blade);
  static ToolLooks MakeLooks(const ReciprocatingBlade& blade);
  static std::vector<Vec3> MakeSection(const ReciprocatingBlade& blade, const Pose& X_ST, double least_mm);
  static std::vector<Vec3> SampleSurface(const ReciprocatingBlade& blade, double step_mm);
};

}  // namespace kerf
