// What effects cost, measured on a scene's own cut: each with it against without it, in turn, along the same way.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/bench/measure.h"
#include "kerf/effects.h"
#include "session/scene/scene.h"

namespace kerf {

struct EffectCostOptions {
  double seconds = 1;                       // of the cut, 0.1 to 60
  int passes = 3;                           // through it, each with and without, 1 to 100
  bool all = false;                         // all that there are, those that the scene does not name with their presets
  bool together_only = false;               // not one by one
  bool by_hand = true;                      // as `kerf loop` holds the tool; else as `kerf run` leads it
  std::optional<int> core;                  // that the ticks are held to; none: wherever the system puts them
  bool realtime = false;                    // ticks go before other programs; needs a core
  const std::atomic<bool>* stop = nullptr;  // ends the measurement by an Error
  std::function<void(const std::string& stage, double fraction)> progress;
};

/// Ticks of one side of a comparison.
struct TickCosts {
  Percentiles cutting;        // each tick as fast as in its fastest pass: the passes do the same work
  Percentiles all;            // of all passes, but for those in which the system took the core away
  std::size_t disturbed = 0;  // how many those were
  Percentiles air;            // the tool in the air, before the cut; as `cutting`
  Percentiles air_after;      // the same after it, and what it left behind
  std::uint64_t bone_hash = 0;
  std::uint64_t force_hash = 0;  // of every tick's force and pose
};

struct EffectCost {
  std::string name;               // of the effect; "all" of all together
  std::string why;                // it is on
  std::vector<std::string> with;  // others that it needs, on both sides
  TickCosts with_it;
  TickCosts without_it;
  double memory_MB = 0;  // that it keeps at the end
  /// Same bone and same forces with it and without.
  bool only_observes() const {
    return with_it.bone_hash == without_it.bone_hash && with_it.force_hash == without_it.force_hash;
  }
};

/// An effect that is not on, and why.
struct EffectLeftOut {
  std::string name;
  std::string why;
};

struct EffectCosts {
  std::string scene;
  std::string title;
  MachineState machine;  // before the measurement
  std::optional<int> core;
  bool realtime = false;
  bool by_hand = true;
  double voxel_mm = 0;
  double rate_hz = 0;  // of the scene's loop, or of its ticks along the path
  double begin_s = 0;  // of the stretch that was measured
  double seconds = 0;
  int passes = 0;
  double mean_teeth = 0;            // engaged there
  std::vector<EffectCost> effects;  // each alone, with those that it needs
  EffectCost together;              // against none
  double bone_MB = 0;
  double simulation_MB = 0;  // besides, with all effects
  std::vector<EffectLeftOut> left_out;

  double fits_kHz() const { return together.with_it.cutting.p99_us > 0 ? 1e3 / together.with_it.cutting.p99_us : 0; }
};

/// Builds the scene's bone, cuts for as long as it takes to find where most teeth are engaged, and measures there.
/// Throws Error: for slab mode, a tool that meets no bone, what makes the scene unfit to run.
EffectCosts MeasureEffects(const Scene& scene, const EffectCostOptions& options);

/// What was measured last on the default scene, by tools/effects_table; part of the program.
struct KeptCost {
  std::string name;
  double p50_us = 0;  // added to a tick in the cut
  double p99_us = 0;
  double air_us = 0;  // whole tick in the air, p50
  double memory_MB = 0;
};
std::vector<KeptCost> KeptEffectCosts();
std::string FormatKeptCosts(const EffectCosts& costs);

std::string FormatEffectCosts(const EffectCosts& costs);          // for a terminal
std::string FormatEffectCostsMarkdown(const EffectCosts& costs);  // for a README
std::string FormatEffectCostsJson(const EffectCosts& costs);
/// All effects there are, or `only` one of them, for a terminal and as JSON.
std::string FormatEffectList(const EffectInfo* only = nullptr);
std::string FormatEffectListJson(const EffectInfo* only = nullptr);

}  // namespace kerf
