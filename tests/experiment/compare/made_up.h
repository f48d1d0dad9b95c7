// Made-up results of a comparison, for tests of conclusions that are known in advance.
#pragma once

#include <functional>
#include <string>

#include "experiment/compare/comparison.h"

namespace kerf::test {

/// Values of a made-up case at each depth.
struct MadeUpCase {
  std::string label;
  bool slab = false;
  std::string law = "hertz_chip";  // only in voxel mode
  std::function<double(double h_mm)> force_N;
  std::function<double(double h_mm)> beyond_N = [](double) { return 0.0; };  // beyond the end of the slice
  std::function<double(double h_mm)> teeth = [](double) { return 2.0; };
  double p50_us = 100;
  double p99_us = 200;
  std::uint64_t memory_bytes = 1'000'000;
  double work_mJ = 50;
};

/// Returns a comparison over a slice of 10 mm in steps of 0.1 mm: region 24 (cortical) down to 4 mm, region 32
/// (cancellous) below that, and 2 mm beyond the slice. It has 1000 ticks per second and two repetitions.
inline Comparison MakeUp(const std::vector<MadeUpCase>& cases) {
  Comparison c;
  c.scene = "made_up";
  c.title = "Made up";
  c.depth_by = "bone";
  c.voxel_mm = 0.1;
  c.rate_hz = 1000;
  c.feed_mm_per_s = 3;
  c.rpm = 7500;
  c.direction_W = {0, 0, -1};
  c.profile.layers = {{0, 24, 20000, 0.3}, {4, 32, 1000, 0.3}};
  c.profile.end_mm = 10;
  c.grid = {0.1, 120};
  c.repetitions = 2;
  for (const MadeUpCase& made : cases) {
    CaseResult r;
    r.what.id = made.label;
    for (char& letter : r.what.id) letter = letter == ' ' ? '_' : letter;
    r.what.label = made.label;
    r.what.slab = made.slab;
    r.what.law = ForceLaw(made.law);
    for (std::size_t i = 0; i < c.grid.count; ++i) {
      const double h = c.grid.Centre(i);
      const double force = h < 10 ? made.force_N(h) : made.beyond_N(h);
      r.curve.force_N.push_back(force);
      r.curve.magnitude_N.push_back(force);
      r.curve.thrust_N.push_back(force);
      r.curve.teeth.push_back(h < 10 ? made.teeth(h) : 0);
    }
    r.curve.reach = c.grid.count;
    r.ticks = r.ticks_on_curve = 1000;
    r.work_mJ = made.work_mJ;
    r.memory_bytes = made.memory_bytes;
    r.times.p50_us = made.p50_us;
    r.times.p99_us = made.p99_us;
    r.times.max_us = 3 * made.p99_us;
    r.p50_us = {made.p50_us, 1.05 * made.p50_us};
    r.p99_us = {made.p99_us, 1.05 * made.p99_us};
    c.cases.push_back(std::move(r));
  }
  MaterialTable materials;
  materials.Add({24, "upper", Tissue::kCortical, 20000, 0.3, true, "test"});
  materials.Add({32, "lower", Tissue::kCancellous, 1000, 0.3, true, "test"});
  FinishComparison(c, materials);
  return c;
}

}  // namespace kerf::test
