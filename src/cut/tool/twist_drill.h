// The twist drill: a cylinder with two lips at its tip, which cut; its side does not, and the hole holds it.
#pragma once

#include "cut/tool/tool_kind.h"

namespace kerf {

RoundSolid MakeDrillSolid(const TwistDrill& drill);

template <>
struct ToolKind<TwistDrill> {
  static constexpr int kLips = 2;
  static constexpr double kChiselRadius =
      0.2;  // half the length of the chisel edge, as a fraction of the radius; assumed
  /// Returns what the chisel edge adds to the thrust of the lips in whole bone, as a multiple of it.
  static double CalcChiselThrust(const TwistDrill& drill) { return drill.chisel_share / (1 - drill.chisel_share); }
  static constexpr std::string_view kShape = "drill";
  static constexpr std::string_view kSummary = "a twist drill, which cuts with the two lips of its tip";
  static constexpr std::string_view kClass = "Drill";
  static constexpr std::string_view kFrame = "origin at the tip, z along the spindle, towards the handpiece";
  static constexpr ToolForm kForm = ToolForm::kRound;
  static constexpr ToolWords kWords{"lip", "tip"};
  static constexpr DriveMotion kDrive = DriveMotion::kRotation;
  static constexpr int kSense = -1;
  static constexpr double kOrdinaryRate_per_min = 1000;
  static std::string Name(const TwistDrill& drill);
  static std::string ShortName(const TwistDrill& drill);
  static double CalcReach(const TwistDrill& drill);
  static double CalcRadius(const TwistDrill& drill) { return drill.radius_mm(); }
  static double CalcCutWidth(const TwistDrill& drill) { return drill.diameter_mm; }
  static int CountPassesPerTurn(const TwistDrill&) { return kLips; }
  static Tooth CalcTooth(const TwistDrill& drill);
  static double CalcSideStiffness(const TwistDrill&) { return 0; }
  static std::optional<RoundSolid> CalcRoundSolid(const TwistDrill& drill);
  static Vec3 FindNearest(const TwistDrill& drill, const Vec3& p_T);
  static double CalcSignedDistance(const TwistDrill& drill, const Vec3& p_T);
  static Vec3 FindDeepest(const TwistDrill& drill, const Vec3& n_T);
  /// The lips are treated as continuous around the axis, each as teeth side by side from the axis to its end.
  static ToolShape MakeShape(const TwistDrill& drill, const ShapeSampling& sampling);
  /// Slices about as thick as they are wide.
  static std::vector<CoverPlate> MakeCover(const TwistDrill& drill);
  static ToolLooks MakeLooks(const TwistDrill& drill);
  static std::vector<Vec3> MakeSection(const TwistDrill& drill, const Pose& X_ST, double least_mm);
  static std::vector<Vec3> SampleSurface(const TwistDrill& drill, double step_mm);
};

}  // namespace kerf
