// The phases of a cut: entry, cut, breakthrough and exit, determined by how much of the rim a reference has engaged.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "experiment/reference/reference.h"

namespace kerf {

/// A time interval of a path.
struct CutPhase {
  std::string name;  // "entry", "cut", "breakthrough", "exit"
  double from_s = 0;
  double to_s = 0;
};

/// E is the 95th percentile of the engaged teeth over the ticks with any. Entry lasts from the first contact until the
/// engaged teeth first reach 0.9 E, cut until they last reach 0.9 E, breakthrough until they last reach 0.1 E, and exit
/// until the last contact. The phases are contiguous. A phase without duration is left out, such as breakthrough and
/// exit if the path ends in the bone. Ticks end at multiples of `tick_s`. Empty without contact.
std::vector<CutPhase> FindCutPhases(std::span<const ReferenceTick> ticks, double tick_s);

}  // namespace kerf
