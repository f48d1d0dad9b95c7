// The paper's force law in two readings, based on its printed text and its printed tables (docs/paper.md).
#pragma once

#include <optional>
#include <string_view>

#include "kerf/tool.h"

// NaN depths or constants give NaN forces.
namespace kerf {

enum class PaperReading {
  kAsComputed,  // "as_computed": arc computed with the diameter in place of the radius, whole teeth, contact radii
                // added before cubing: F = n^3 F_1. Reproduces the paper's 24 forces.
  kCorrected,   // "corrected": true arc, real number of teeth, sum of the teeth's forces: F = n F_1
};
std::string_view ToString(PaperReading reading);
std::optional<PaperReading> PaperReadingFromString(std::string_view word);

/// Computes the arc as in the paper's tables, mm: d acos(1 - h / (2 d)). `depth_mm` is clamped to 0..d. Tick-safe.
double CalcPaperArc(double depth_mm, double diameter_mm);

/// Computes the true arc of the rim from its lowest point up to the surface, mm: (d/2) acos(1 - 2 h / d). A disc fed
/// parallel to the surface at depth h engages this arc. `depth_mm` is clamped to 0..d. Tick-safe.
double CalcTrueArc(double depth_mm, double diameter_mm);

/// Computes Hertz's K in a = K F^(1/3), mm N^(-1/3): [3 d1 ((1 - nu1^2)/E1 + (1 - nu2^2)/E2) / 8]^(1/3), with the disc
/// (1) as a sphere on a half space (2). This is the paper's eq. (3) with Hertz's nu^2 in place of its printed nu.
/// Tick-safe.
double CalcHertzK(const DiscSaw& saw, double E2_MPa, double nu2);

/// Computes the force on one tooth, N: (a / K)^3 with a = fraction_of_pitch * pitch. Tick-safe.
double CalcPaperToothForce(const DiscSaw& saw, double fraction_of_pitch, double E2_MPa, double nu2);

/// Rounds a number of teeth down. A number that is below an integer only by rounding error is rounded to that integer.
/// Tick-safe.
double FloorTeeth(double teeth);

/// Computes the number of engaged teeth at a depth, by the chosen reading: FloorTeeth(CalcPaperArc / pitch), or
/// CalcTrueArc / pitch as a real number. Tick-safe.
double CalcPaperTeeth(const DiscSaw& saw, double depth_mm, PaperReading reading);

/// Computes the force of n teeth in one material, N: n^3 F_1 or n F_1, by the chosen reading. Tick-safe.
double CalcPaperForce(const DiscSaw& saw, double fraction_of_pitch, double depth_mm, double E2_MPa, double nu2,
                      PaperReading reading);

}  // namespace kerf
