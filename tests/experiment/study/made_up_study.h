// A study whose figures follow power laws, for tests of plots and reports.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "experiment/study/knobs.h"
#include "experiment/study/records.h"

namespace kerf::test {

inline CaseRecord MakeCase(Holding holding, const std::string& path, const std::string& knob, const std::string& value,
                           double number, double error, double p99_us) {
  CaseRecord record;
  record.id = fmt::format("{}-{}-{}-{}", ToString(holding), path, knob, value);
  record.holding = holding;
  record.path = path;
  record.knob = knob;
  record.value = value;
  record.number = number;
  ErrorFigures errors;
  errors.force_l2 = 0.6 * error;
  errors.force_p95 = error;
  errors.force_worst = 2.5 * error;
  errors.force_worst_N = 10 * error;
  errors.direction_p95_deg = 60 * error;
  errors.direction_worst_deg = 150 * error;
  errors.impulse = 0.2 * error;
  errors.impulse_signed = path == "breakthrough" ? -0.2 * error : 0.2 * error;
  errors.noise_N = 0.1 * error;
  errors.volume = 0.1 * error;
  errors.surface_mean_mm = 0.3 * error;
  errors.surface_p95_mm = 0.6 * error;
  errors.surface_max_mm = error;
  if (path == "breakthrough") errors.breakthrough_ms = -3.5;
  if (knob == "heat_grid_mm") errors.temperature_K = 2 * number * number;
  record.errors = errors;
  CostFigures costs;
  costs.ticks = 100000;
  costs.tick = {100000, 0.6 * p99_us, p99_us, 1.4 * p99_us, 3 * p99_us};
  costs.undisturbed = {99000, 0.59 * p99_us, 0.95 * p99_us, 1.2 * p99_us, 2 * p99_us};
  costs.misses_per_million = p99_us > 700 ? 120 : 0;
  costs.memory_MB = 80;
  costs.setup_s = 0.4;
  costs.whole_s = 2;
  costs.histogram = {{300, 60000}, {330, 39000}, {340, 1000}};
  record.costs = costs;
  record.force_hash = 0x0123456789abcdef;
  record.bone_hash = 0xfedcba9876543210;
  return record;
}

/// Returns a study of eleven paths, with errors of 2.4 % to 3 % at the defaults. The error of each knob has its
/// theoretical order.
inline StudyResults MakeStudy() {
  StudyResults study;
  study.base.law = "hertz_chip";  // of its references
  study.name = "made_up";
  study.title = "A study of \"made-up\" figures, to look at";
  study.command = "kerf study made_up.toml -o out/";
  study.commit = "0123456789ab";
  study.build = "GNU 12.2.0, -O3";
  study.machine.cpu = "Imaginary 9000 at 3 GHz";
  study.machine.cores = 2;
  study.machine.load = 0.25;
  study.seconds = 1234.5;
  study.paths = {"entry", "slot",    "plunge",    "graze", "border", "breakthrough",
                 "tilt",  "reentry", "free_form", "idle",  "worst"};
  for (const std::string& path : study.paths) study.path_titles[path] = "the way called " + path;
  study.knobs = {"voxel_mm", "rim_samples_per_pitch", "substeps",     "rate_hz", "carve_interval_ticks", "law",
                 "material", "precision_bits",        "heat_grid_mm", "method",  "band_voxels"};
  struct Value {
    const char* knob;
    const char* value;
    double number, error, time;  // relative to the default
  };
  const std::vector<Value> values = {{"voxel_mm", "0.025", 0.025, 0.03, 4},  // below the references' error bars
                                     {"voxel_mm", "0.05", 0.05, 0.55, 2.4},
                                     {"voxel_mm", "0.2", 0.2, 1.9, 0.6},
                                     {"voxel_mm", "0.4", 0.4, 3.7, 0.45},
                                     {"voxel_mm", "0.8", 0.8, 7.6, 0.4},
                                     {"rim_samples_per_pitch", "2", 2, 4, 0.7},
                                     {"rim_samples_per_pitch", "4", 4, 1.7, 0.8},
                                     {"rim_samples_per_pitch", "16", 16, 0.95, 1.5},
                                     {"substeps", "2", 2, 0.85, 1.9},
                                     {"substeps", "4", 4, 0.8, 3.7},
                                     {"rate_hz", "500", 500, 1.8, 1.15},
                                     {"rate_hz", "2000", 2000, 0.8, 0.9},
                                     {"rate_hz", "4000", 4000, 0.75, 0.85},
                                     {"carve_interval_ticks", "2", 2, 1.6, 1.0},
                                     {"carve_interval_ticks", "4", 4, 2.9, 0.98},
                                     {"carve_interval_ticks", "10", 10, 6.5, 0.97},
                                     {"law", "edge_plus_chip", 0, 1.1, 1.02},
                                     {"material", "ct", 0, 2.2, 1.01},
                                     {"precision_bits", "11", 11, 1.3, 1.0},
                                     {"precision_bits", "8", 8, 4.1, 1.0},
                                     {"heat_grid_mm", "1", 1, 1.0, 1.4},
                                     {"heat_grid_mm", "0.5", 0.5, 1.0, 2.1},
                                     {"method", "coarse", 0, 2.6, 0.5},
                                     {"method", "slab", 0, 9, 0.03},
                                     {"band_voxels", "5", 5, 1.0, 1.08}};
  for (const Holding holding : {Holding::kHand, Holding::kPath}) {
    for (std::size_t p = 0; p < study.paths.size(); ++p) {
      const std::string& path = study.paths[p];
      const bool idle = path == "idle";
      const double error = idle ? 0 : 0.024 + 0.0006 * static_cast<double>(p);
      const double time_us = (idle ? 20 : 120 + 12 * static_cast<double>(p)) * (holding == Holding::kPath ? 0.6 : 1);
      study.cases.push_back(MakeCase(holding, path, "default", "", 0, error, time_us));
      for (const Value& v : values) {
        const bool wobble = (p + static_cast<std::size_t>(v.number)) % 2 == 0;
        CaseRecord record = MakeCase(holding, path, v.knob, v.value, v.number, error * v.error * (wobble ? 1.06 : 0.97),
                                     time_us * v.time);
        if (std::string(v.value) == "slab" && (path == "tilt" || path == "graze")) {
          record.state = CaseState::kOmitted;
          record.why = "slab mode has one direction; the path turns";
          record.errors.reset(), record.costs.reset();
        }
        study.cases.push_back(record);
      }
      ReferenceRecord reference;
      reference.holding = holding;
      reference.path = path;
      reference.input_hash = 0xabc0000000000000 + p;
      reference.force_hash = 0xdef0000000000000 + p;
      reference.steps_per_tick = 8;
      reference.error_bar = idle ? 0 : 0.0012 + 0.0001 * static_cast<double>(p);
      reference.error_bar_l2 = 0.5 * reference.error_bar;
      reference.volume_bar = 1e-4;
      reference.seconds = 12;
      reference.note = idle ? "closed form: no force" : "";
      study.references.push_back(reference);
      reference.variant = "law=edge_plus_chip";
      study.references.push_back(reference);
    }
  }
  return study;
}

}  // namespace kerf::test
