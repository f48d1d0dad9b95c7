// Warnings about a simulation whose ticks a program runs itself: what `kerf run`, `kerf loop` and the slab mode say
// about settings and motions that are valid but rarely intended.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/coupled.h"
#include "kerf/scene.h"
#include "kerf/simulation.h"
#include "kerf/slab.h"

namespace kerf {

/// Follows the ticks of a Simulation or a CoupledSimulation, which does not need it.
class TickWarnings {
 public:
  /// `bone`: that of the simulation at its start. `channels`: ListChannels() of the simulation.
  TickWarnings(const SimulationParams& params, const Bone& bone, const Pose& X_WT_start,
               const std::vector<std::string>& channels = {});
  TickWarnings(const CoupledParams& params, const Bone& bone, const std::vector<std::string>& channels = {});
  ~TickWarnings();
  TickWarnings(TickWarnings&&) noexcept;
  TickWarnings& operator=(TickWarnings&&) noexcept;

  /// Call one of these after each tick. `channels`: as ReadChannels() gives them. Tick-safe.
  void Add(const TickInput& in, const TickOutput& out, std::span<const double> channels = {});
  void Add(const CoupledInput& in, const CoupledOutput& out, std::span<const double> channels = {});
  /// Call after SetDown(). Tick-safe.
  void SetDown(const Pose& X_WT);
  /// Call after bone has been restored: its energy of cutting is then unknown. Tick-safe.
  void BoneRestored();

  /// Returns the warnings about the ticks so far, one sentence each. `removed_mm3`: the sum of CalcRemovedByRegion().
  std::vector<std::string> Find(double removed_mm3) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the warnings about a slab simulation of a scene. `start`: its state before the first tick. `now`: after the
/// last one; null: there was none.
std::vector<std::string> FindSlabWarnings(const SceneFile& scene, const SlabState& start, const SlabState* now);

}  // namespace kerf
