// The paper's force law in two readings that its printed text and its printed tables give (docs/paper.md).
#pragma once

#include <optional>
#include <string_view>

#include "kerf/tool.h"

// A depth or a constant that is not a number gives a force that is none.
namespace kerf {

enum class PaperReading {
  kAsComputed,  // "as_computed": the arc with the diameter where the radius belongs, whole teeth, contact radii added
                // before cubing: F = n^3 F_1. Gives the paper's 24 forces.
  kCorrected,   // "corrected": the true arc, a real number of teeth, the forces of the teeth summed: F = n F_1
};
std::string_view ToString(PaperReading reading);
std::optional<PaperReading> PaperReadingFromString(std::string_view word);

/// The arc that the tables were computed with, mm: d acos(1 - h / (2 d)). `depth_mm` is held to 0..d. Tick-safe.
double CalcPaperArc(double depth_mm, double diameter_mm);

/// The true arc of the rim from its lowest point up to the surface, mm: (d/2) acos(1 - 2 h / d), which is what a disc
/// engages that is fed level at depth h. `depth_mm` is held to 0..d. Tick-safe.
double CalcTrueArc(double depth_mm, double diameter_mm);

/// Hertz's K in a = K F^(1/3), mm N^(-1/3): [3 d1 ((1 - nu1^2)/E1 + (1 - nu2^2)/E2) / 8]^(1/3) with the disc (1) as the
/// sphere on a half space (2). The paper's eq. (3), with Hertz's nu^2 where it prints nu. Tick-safe.
double CalcHertzK(const DiscSaw& saw, double E2_MPa, double nu2);

/// Force on one tooth, N: (a / K)^3 with a = share_of_pitch * pitch. Tick-safe.
double CalcPaperToothForce(const DiscSaw& saw, double share_of_pitch, double E2_MPa, double nu2);

/// Whole teeth in a real number of them; one that is whole but for rounding keeps its last. Tick-safe.
double FloorTeeth(double teeth);

/// Teeth engaged at a depth: FloorTeeth(CalcPaperArc / pitch), or CalcTrueArc / pitch as a real number. Tick-safe.
double CalcPaperTeeth(const DiscSaw& saw, double depth_mm, PaperReading reading);

/// Force of n teeth in one material, N: n^3 F_1 or n F_1. Tick-safe.
double CalcPaperForce(const DiscSaw& saw, double share_of_pitch, double depth_mm, double E2_MPa, double nu2,
                      PaperReading reading);

}  // namespace kerf
