// The fissure bur: a cylinder or cone with flutes, which cuts with its side and its end.
#pragma once

#include "cut/tool/tool_kind.h"

namespace kerf {

RoundSolid MakeBurSolid(const FissureBur& bur);

template <>
struct ToolKind<FissureBur> {
  static constexpr std::string_view kShape = "bur";
  static constexpr std::string_view kSummary = "a fissure or Lindemann bur, which cuts with its side and its end";
  static constexpr std::string_view kClass = "Bur";
  static constexpr std::string_view kFrame = "origin at the tip, z along the spindle, towards the handpiece";
  static constexpr ToolForm kForm = ToolForm::kRound;
  static constexpr ToolWords kWords{"flute", "side"};
  static constexpr DriveMotion kDrive = DriveMotion::kRotation;
  static constexpr int kSense = -1;
  static constexpr double kOrdinaryRate_per_min = 40'000;
  static std::string Name(const FissureBur& bur);
  static std::string ShortName(const FissureBur& bur);
  static double CalcReach(const FissureBur& bur);
  static double CalcRadius(const FissureBur& bur) { return bur.radius_mm(); }
  static double CalcCutWidth(const FissureBur& bur) { return bur.diameter_mm; }
  static int CountPassesPerTurn(const FissureBur& bur) { return bur.flutes; }
  static Tooth CalcTooth(const FissureBur& bur);
  static double CalcSideStiffness(const FissureBur&) { return 0; }
  static std::optional<RoundSolid> CalcRoundSolid(const FissureBur& bur);
  static Vec3 FindNearest(const FissureBur& bur, const Vec3& p_T);
  static double CalcSignedDistance(const FissureBur& bur, const Vec3& p_T);
  static Vec3 FindDeepest(const FissureBur& bur, const Vec3& n_T);
  /// The teeth are treated as continuous along the flutes and around the axis, as those of a ball burr.
  static ToolShape MakeShape(const FissureBur& bur, const ShapeSampling& sampling);
  /// Slices of the head about as thick as they are wide.
  static std::vector<CoverPlate> MakeCover(const FissureBur& bur);
  static ToolLooks MakeLooks(const FissureBur& bur);
  static std::vector<Vec3> MakeSection(const FissureBur& bur, const Pose& X_ST, double least_mm);
  static std::vector<Vec3> SampleSurface(const FissureBur& bur, double step_mm);
};

}  // namespace kerf
