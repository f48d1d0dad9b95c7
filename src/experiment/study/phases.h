// The phases of a cut: entry, cut, breakthrough and exit, determined from the number of teeth that are engaged in a
// reference.
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

/// Returns the phases of a cut. E is the 95th percentile of the number of engaged teeth over the ticks with contact.
/// The entry lasts from the first contact until at least 0.9 E teeth are engaged for the first time, the cut until at
/// least 0.9 E teeth are engaged for the last time, the breakthrough until at least 0.1 E teeth are engaged for the
/// last time, and the exit until the last contact. The phases are contiguous. A phase without duration is left out,
/// such as the breakthrough and the exit if the path ends in the bone. Ticks end at multiples of `tick_s`. The result
/// is empty if there is no contact.
std::vector<CutPhase> FindCutPhases(std::span<const ReferenceTick> ticks, double tick_s);

}  // namespace kerf
