// The ball burr: a sphere with flutes from pole to pole, all of which cuts.
#pragma once

#include "cut/tool/tool_kind.h"

namespace kerf {

template <>
struct ToolKind<BallBurr> {
  static constexpr std::string_view kShape = "ball";
  static constexpr std::string_view kSummary = "a burr that cuts with its whole surface";
  static constexpr std::string_view kClass = "Ball";
  static constexpr std::string_view kFrame = "origin at the ball's centre, z along the spindle, towards the handpiece";
  static constexpr ToolForm kForm = ToolForm::kBall;
  static constexpr ToolWords kWords{"flute", "surface"};
  static constexpr DriveMotion kDrive = DriveMotion::kRotation;
  static constexpr int kSense = -1;
  static constexpr double kOrdinaryRate_per_min = 20'000;
  static std::string Name(const BallBurr& ball);
  static std::string ShortName(const BallBurr& ball);
  static double CalcReach(const BallBurr& ball) { return ball.radius_mm(); }
  static double CalcRadius(const BallBurr& ball) { return ball.radius_mm(); }
  static double CalcCutWidth(const BallBurr& ball) { return ball.diameter_mm; }
  static int CountPassesPerTurn(const BallBurr& ball) { return ball.flutes; }
  static Tooth CalcTooth(const BallBurr& ball);
  static double CalcSideStiffness(const BallBurr&) { return 0; }
  static std::optional<RoundSolid> CalcRoundSolid(const BallBurr&) { return {}; }
  static Vec3 FindNearest(const BallBurr& ball, const Vec3& p_T);
  static double CalcSignedDistance(const BallBurr& ball, const Vec3& p_T);
  static Vec3 FindDeepest(const BallBurr& ball, const Vec3& n_T);
  /// The teeth are treated as continuous along the flutes. An element of the sphere between two circles of latitude and
  /// two meridians represents flutes / (2 pi) * d(longitude) * r d(latitude) / tooth_width teeth, independent of the
  /// latitude.
  static ToolShape MakeShape(const BallBurr& ball, const ShapeSampling& sampling);
  /// None: a ball needs no cover.
  static std::vector<CoverPlate> MakeCover(const BallBurr&) { return {}; }
  static ToolLooks MakeLooks(const BallBurr& ball);
  static std::vector<Vec3> MakeSection(const BallBurr& ball, const Pose& X_ST, double least_mm);
  static std::vector<Vec3> SampleSurface(const BallBurr& ball, double step_mm);
};

}  // namespace kerf
