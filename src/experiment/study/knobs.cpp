#include "experiment/study/knobs.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/core/nearest_name.h"
#include "kerf/error.h"

namespace kerf {

const std::vector<Knob>& StudyKnobs() {
  static const std::vector<Knob> knobs = {
      {"voxel_mm", "voxel edge (mm)", "1: the look-ahead and the rounding of edges are fractions of a voxel", 1},
      {"rim_samples_per_pitch", "rim samples per tooth pitch",
       "-1: the ends of an arc are located to a sixteenth of the sample spacing (between them -2, the trapezoidal "
       "rule)",
       -1},
      {"substeps", "steps per tick", "-1: implicit Euler, first order in the step", -1},
      {"rate_hz", "ticks per second", "-1: implicit Euler, first order in the step", -1},
      {"carve_interval_ticks", "ticks between removals",
       "1: the tool is ahead of the removal by the distance that it moves between removals", 1},
      {"law", "force law", "", 0, false},
      {"material", "source of E", "", 0, false},
      {"precision_bits", "significand of the distances (bits)", "", 0},
      {"method", "method", "", 0, false},
      {"heat_grid_mm", "cell of the heat grid (mm)",
       "1: heat enters half a cell deep and a cell behind the edge, and walls are located to a fraction of a cell", 1},
      {"band_voxels", "half width of the band (voxels)", "", 0},
  };
  return knobs;
}

const Knob& FindKnob(const std::string& name) {
  const std::vector<Knob>& knobs = StudyKnobs();
  const auto found = std::find_if(knobs.begin(), knobs.end(), [&](const Knob& knob) { return knob.name == name; });
  if (found != knobs.end()) return *found;
  std::vector<std::string> names;
  for (const Knob& knob : knobs) names.push_back(knob.name);
  const std::string nearest = FindNearestName(name, names);
  throw Error(fmt::format("there is no knob \"{}\"{}", name,
                          nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
}

}  // namespace kerf
