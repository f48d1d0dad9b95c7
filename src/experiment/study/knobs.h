// The parameters that a study can vary: the settings of a case, and the knobs, each of which changes one setting.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// The defaults are kerf's own.
struct StudySettings {
  double voxel_mm = 0.1;
  int rim_samples_per_pitch = 16;
  int substeps = 1;  // minimum per tick
  double rate_hz = 1000;
  int carve_interval_ticks = 1;  // ticks between two removals of bone
  std::string law = "two_component";
  std::string material = "regions";
  int precision_bits = 24;       // bits of the significand of the distances in the voxels: 24 as in float, 11 as in
                                 // half
  std::string method = "voxel";  // voxel, coarse, slab
  double heat_grid_mm = 0;       // 0: heat is not simulated
  int band_voxels = 3;           // half width of the level set's band
};

struct Knob {
  std::string name;      // key in the study file: "voxel_mm"
  std::string label;     // for the user and for axes: "voxel edge (mm)"
  std::string theory;    // theoretical order and its reason, for the user; empty if none is expected
  double order = 0;      // theoretical exponent of the knob's number in the force error (above 0, the error grows with
                         // the number); 0: none is expected
  bool numeric = true;   // false: the values are words, so there is no slope
  bool for_path = true;  // whether it is also meaningful for a position-controlled tool
};

/// Returns all knobs, in the order of docs/accuracy.md.
const std::vector<Knob>& StudyKnobs();
/// Returns the knob of that name. If there is none, throws Error naming the most similar knob.
const Knob& FindKnob(const std::string& name);

}  // namespace kerf
