// The blade of a reciprocating saw: a flat plate with teeth on one long side.
#pragma once

#include "cut/tool/planar_kind.h"

namespace kerf {

template <>
struct ToolKind<ReciprocatingBlade> : PlanarToolKind<ReciprocatingBlade> {
  static constexpr std::string_view kShape = "reciprocating";
  static constexpr std::string_view kSummary = "a blade that a stroke moves along its straight toothed edge";
  static constexpr std::string_view kClass = "ReciprocatingBlade";
  static constexpr std::string_view kFrame =
      "origin at the middle of the toothed edge in the middle of the stroke, y along the edge towards the tip, x the "
      "feed "
      "direction, z across the blade";
  static constexpr double kOrdinaryRate_per_min = 15'000;
  static PlanarBlade Make(const ReciprocatingBlade& blade);
  static std::string Name(const ReciprocatingBlade& blade);
  static std::string ShortName(const ReciprocatingBlade& blade);
  /// Of the blade as a plate that the handle holds, for a force at the tip.
  static double CalcSideStiffness(const ReciprocatingBlade& blade) {
    return CalcPlateStiffness(blade.E_MPa, blade.width_mm, blade.thickness_mm, blade.length_mm);
  }
};

}  // namespace kerf
