// kerf run --uncertain: repeats a run with the parameters of its law and the stiffness of its bone drawn from their
// stated intervals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/table/shard.h"
#include "experiment/uncertainty/drawing.h"
#include "kerf/describe.h"
#include "session/scene/scene.h"

namespace kerf {

struct UncertainParams {
  int samples = 200;
  std::uint64_t seed = 1;
  int jobs = 0;
  std::vector<FitInterval> fit = {};  // intervals in place of those that the law states
};

template <typename V>
void Describe(UncertainParams& p, V&& visit) {
  visit("samples", p.samples, Range{2, 100000},
        "repeat the run with the parameters of the law and E of the bone drawn from their stated intervals, and write "
        "the force as a band (docs/uncertainty.md)");
  visit("seed", p.seed, Range{0, 4294967295.0}, "seed of the drawn values");
  visit("jobs", p.jobs, Range{0, 4096}, "number of runs computed at once; 0: one for each core");
}

/// A row is the mean over a few consecutive ticks of one stroke.
struct BandRows {
  std::vector<double> time_s;        // path time at the end
  std::vector<std::size_t> segment;  // zero-based
  std::vector<double> travel_mm;     // of the nominal run, at the end
  bool operator==(const BandRows&) const = default;
};

/// Results of one run.
struct UncertainSample {
  int number = 0;                 // zero-based; -1: the nominal run
  std::vector<double> fractions;  // in the order of Drawing::drawn; empty for the nominal run
  double peak_N = 0;              // as in ForceSummary
  double mean_N = 0;
  double work_mJ = 0;               // done by the hand along the path
  std::optional<double> cutting_J;  // as in CuttingEnergy::work_J
  std::vector<double> force_N;      // by row: mean magnitude of the force on the tool
  std::vector<double> thrust_N;     // by row: mean of the sum of the teeth's thrust

  bool operator==(const UncertainSample&) const = default;
};

/// All that determines the samples. Shards of one run have equal heads.
struct UncertainHead {
  std::string scene;  // name of the file, without folder and extension
  std::string title;
  std::string law;
  std::string scene_sha256;  // of the resolved scene
  std::uint64_t bone_hash = 0;
  int samples = 0;  // of the whole run
  std::uint64_t seed = 0;
  Drawing drawing;
  int row_ticks = 1;  // largest number of ticks in a row
  double rate_hz = 0;
  BandRows rows;
  UncertainSample nominal;

  bool operator==(const UncertainHead&) const = default;
};

struct UncertainRun {
  UncertainHead head;
  std::vector<UncertainSample> samples;  // by number; those that were computed
};

/// Runs the nominal scene and its samples, or those of a shard: the samples whose number is index modulo count. The
/// results depend on neither the number of threads nor the shards. `progress` is called from several threads, one call
/// at a time. Throws kerf::Error if the scene is in slab mode, nothing in it has an interval, or a run fails.
UncertainRun RunUncertain(const Scene& scene, const UncertainParams& params, const std::optional<Shard>& shard,
                          const std::function<void(const std::string& stage, double fraction)>& progress);

/// Returns the SHA-256 of the resolved scene.
std::string HashScene(const Scene& scene);

}  // namespace kerf
