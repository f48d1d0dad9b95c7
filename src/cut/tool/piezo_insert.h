// The saw insert of a piezoelectric handpiece: a small flat plate whose toothed end vibrates along its teeth.
#pragma once

#include "cut/tool/planar_kind.h"

namespace kerf {

template <>
struct ToolKind<PiezoInsert> : PlanarToolKind<PiezoInsert> {
  static constexpr std::string_view kShape = "piezo";
  static constexpr std::string_view kSummary = "a small saw insert whose toothed end vibrates along its teeth";
  static constexpr std::string_view kClass = "PiezoInsert";
  static constexpr std::string_view kFrame =
      "origin at the middle of the toothed end in the middle of the stroke, x the feed direction, y along the edge, z "
      "across the insert";
  static constexpr Range kRates_per_min{kMinRpm, kMaxStrokesPerMin, kOrZero};
  static constexpr double kOrdinaryRate_per_min = 1'740'000;  // 29 kHz
  static PlanarBlade Make(const PiezoInsert& insert);
  static std::string Name(const PiezoInsert& insert);
  static std::string ShortName(const PiezoInsert& insert);
  /// Of a plate of the mean width that is held at its back, for a force at the teeth.
  static double CalcSideStiffness(const PiezoInsert& insert) {
    return CalcPlateStiffness(insert.E_MPa, 0.5 * (1 + insert.taper) * insert.width_mm, insert.thickness_mm,
                              insert.length_mm);
  }
};

}  // namespace kerf
