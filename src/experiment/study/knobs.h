// What a study can turn: the settings of a case, and the knobs that change one of them each.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// The base settings are what kerf ships.
struct StudySettings {
  double voxel_mm = 0.1;
  int rim_samples_per_pitch = 16;
  int substeps = 1;  // at least so many in each tick
  double rate_hz = 1000;
  int carve_interval_ticks = 1;  // ticks between two removals of bone
  std::string law = "hertz_chip";
  std::string material = "regions";
  int precision_bits = 24;       // significand of the distances in the voxels: 24 float, 11 half
  std::string method = "voxel";  // voxel, coarse, slab
  double heat_grid_mm = 0;       // 0: heat is not simulated
  int band_voxels = 3;           // half width of the level set's band
};

struct Knob {
  std::string name;      // key in the study file: "voxel_mm"
  std::string label;     // for people and axes: "voxel edge (mm)"
  std::string theory;    // the order that theory gives and why, for people; empty: none is expected
  double order = 0;      // of the force's error in the knob's number (positive: falls as the number does); 0: none
  bool numeric = true;   // false: words, no slope
  bool for_path = true;  // means something when the tool is led along its path
};

/// All knobs, in the order of docs/accuracy.md.
const std::vector<Knob>& StudyKnobs();
/// Throws Error naming the nearest knob.
const Knob& FindKnob(const std::string& name);

}  // namespace kerf
