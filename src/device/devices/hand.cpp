#include "device/devices/hand.h"

#include <fmt/format.h>

#include "kerf/error.h"

namespace kerf {

const std::vector<HandModel>& HandModels() {
  // Higher-order models from the literature (a third-order stylus grip by Fu and Cavusoglu 2012, five parameters by
  // Speich, Shao and Goldfarb 2005) are omitted: their parameters were not available.
  static const std::vector<HandModel> hands = {
      {"H0", 0, 0, 0, 0, 0, "released: the device alone"},
      {"H1", 0.02, 0.001, 0.1, 500, 5,
       "light pinch; order of magnitude of a fingertip (Hajian and Howe 1997), recalled, not verified; torsion "
       "assumed"},
      {"H2", 0.10, 0.003, 0.2, 1000, 10, "pen grip; middle of the range, recalled, not verified; torsion assumed"},
      {"H3", 0.554, 0.00645, 0.135, 2000, 20,
       "arm holding a posture; measured by perturbation with a HapticMaster (Scientific Reports 2015, srep18004, fig. "
       "3); torsion assumed"},
      {"H4", 0.30, 0.015, 0.5, 4000, 40, "firm power grip; upper range, recalled, not verified; torsion assumed"},
  };
  return hands;
}

const HandModel& FindHandModel(const std::string& name) {
  std::string names;
  for (const HandModel& hand : HandModels()) {
    if (hand.name == name) return hand;
    names += (names.empty() ? "" : ", ") + hand.name;
  }
  throw Error(fmt::format("hand \"{}\" is unknown; the hands are {}", name.substr(0, 60), names));
}

}  // namespace kerf
