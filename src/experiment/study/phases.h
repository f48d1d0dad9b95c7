// The phases of a cut: entry, cut, breakthrough and exit, by how much of the rim a reference has engaged.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "experiment/reference/reference.h"

namespace kerf {

/// A stretch of time of a path.
struct CutPhase {
  std::string name;  // "entry", "cut", "breakthrough", "exit"
  double from_s = 0;
  double to_s = 0;
};

/// With E the 95th percentile of the engaged teeth over the ticks that have any: entry from the first contact until the
/// engaged teeth first reach 0.9 E, cut until they last do, breakthrough until they last reach 0.1 E, exit until the
/// last contact. Phases follow one another without a gap; one that takes no time, as breakthrough and exit where the
/// path ends in the bone, is left out. Ticks end at multiples of `tick_s`. Empty without contact.
std::vector<CutPhase> FindCutPhases(std::span<const ReferenceTick> ticks, double tick_s);

}  // namespace kerf
