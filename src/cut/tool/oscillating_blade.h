// The blade of an oscillating (sagittal) saw: a flat plate with teeth on an arc at its end, which swings.
#pragma once

#include "cut/tool/planar_kind.h"

namespace kerf {

template <>
struct ToolKind<OscillatingBlade> : PlanarToolKind<OscillatingBlade> {
  static constexpr std::string_view kShape = "oscillating";
  static constexpr std::string_view kSummary = "a blade that swings about an axis behind the toothed arc at its end";
  static constexpr std::string_view kClass = "OscillatingBlade";
  static constexpr std::string_view kFrame =
      "origin at the middle of the toothed arc in the middle of the swing, x the feed direction, y along the edge, z "
      "across the blade, along the swing axis";
  static constexpr double kOrdinaryRate_per_min = 15'000;
  static PlanarBlade Make(const OscillatingBlade& blade);
  static std::string Name(const OscillatingBlade& blade);
  static std::string ShortName(const OscillatingBlade& blade);
  /// Of a plate of the mean width that is held at the swing axis, for a force at the teeth.
  static double CalcSideStiffness(const OscillatingBlade& blade) {
    return CalcPlateStiffness(blade.E_MPa, 0.5 * (1 + blade.taper) * blade.width_mm, blade.thickness_mm,
                              blade.radius_mm);
  }
};

}  // namespace kerf
