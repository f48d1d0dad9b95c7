// Cost of effects, measured on a scene's own cut: each effect with and without, alternately, along the same path.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "base/table/run_info.h"
#include "base/table/table.h"
#include "experiment/bench/measure.h"
#include "kerf/effects.h"
#include "session/scene/scene.h"

namespace kerf {

struct EffectCostOptions {
  double seconds = 1;
  int passes = 3;              // each with and without the effect
  bool all = false;            // measure all effects; those that the scene does not name use their defaults
  bool together_only = false;  // do not measure each effect alone
  bool by_hand = true;         // coupled to a handle as in `kerf loop`; otherwise position-controlled as in `kerf run`
  std::optional<int> core;     // core for the ticks; if unset, the system chooses
  bool realtime = false;       // ticks run with real-time priority; needs a core
  const std::atomic<bool>* stop = nullptr;  // if true, ends the measurement with an Error
  std::function<void(const std::string& stage, double fraction)> progress;
};

template <typename V>
void Describe(EffectCostOptions& p, V&& visit) {
  visit("seconds", p.seconds, Range{0.1, 60}, "duration of the timed part of the cut, where most teeth are engaged");
  visit("passes", p.passes, Range{1, 100}, "repetitions of the timed part");
  DescribeCore(p.core, visit);
}

/// Ticks of one side of a comparison.
struct TickCosts {
  Percentiles cutting;        // of the shortest time of each tick in any pass, since all passes do the same work
  Percentiles all;            // of all passes, except for ticks in which the system interrupted the thread
  std::size_t disturbed = 0;  // number of those interrupted ticks
  Percentiles air;            // with the tool in the air before the cut; computed in the same way as `cutting`
  Percentiles air_after;      // the same after the cut, so that its lasting consequences are included
  std::uint64_t bone_hash = 0;
  std::uint64_t force_hash = 0;  // of the force and the pose of every tick
};

struct EffectCost {
  std::string name;               // name of the effect; "all" for all effects together
  std::string why;                // reason why it is enabled
  std::vector<std::string> with;  // other effects that it needs, enabled on both sides of the comparison
  TickCosts with_it;
  TickCosts without_it;
  double memory_MB = 0;  // occupied by the effect at the end
  /// Returns true if the bone and the forces are the same with and without the effect.
  bool only_observes() const {
    return with_it.bone_hash == without_it.bone_hash && with_it.force_hash == without_it.force_hash;
  }
};

/// An effect that is disabled, and the reason.
struct EffectLeftOut {
  std::string name;
  std::string why;
};

struct EffectCosts {
  std::string scene;
  std::string title;
  RunInfo run;
  bool by_hand = true;
  double voxel_mm = 0;
  double rate_hz = 0;  // rate of the scene's loop, or of its ticks along the path
  double begin_s = 0;  // start of the measured part
  double seconds = 0;
  int passes = 0;
  double mean_teeth = 0;            // engaged in the measured part
  std::vector<EffectCost> effects;  // each one alone, except for the effects that it needs
  EffectCost together;              // all effects compared with none
  double bone_MB = 0;
  double simulation_MB = 0;  // in addition to the bone, with all effects
  std::vector<EffectLeftOut> left_out;

  double fits_kHz() const { return together.with_it.cutting.p99_us > 0 ? 1e3 / together.with_it.cutting.p99_us : 0; }
};

/// Builds the scene's bone, cuts until it finds the part with the most teeth engaged, and measures there. Throws Error
/// for slab mode, for a tool that touches no bone, and for a scene that cannot run.
EffectCosts MeasureEffects(const Scene& scene, const EffectCostOptions& options);

/// Figures of the last measurement on the default scene, which tools/effects_table makes. They are built into the
/// program.
struct StoredCost {
  std::string name;
  double p50_us = 0;  // added to a tick in the cut
  double p99_us = 0;
  double air_us = 0;  // median of the whole tick in air, the larger of those before and after the cut
  double memory_MB = 0;
};
std::vector<StoredCost> StoredEffectCosts();
/// Describes the columns of volumes/effect_costs.csv.
const Columns<EffectCost>& EffectCostColumns();
std::string FormatStoredCosts(const EffectCosts& costs);

std::string FormatEffectCosts(const EffectCosts& costs);          // for a terminal
std::string FormatEffectCostsMarkdown(const EffectCosts& costs);  // for a README
std::string FormatEffectCostsJson(const EffectCosts& costs);
/// These list all effects, or only `only` if it is not null, for a terminal and as JSON.
std::string FormatEffectList(const EffectInfo* only = nullptr);
std::string FormatEffectListJson(const EffectInfo* only = nullptr);

}  // namespace kerf
