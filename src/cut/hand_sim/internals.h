// What kerf's own sources use of a simulation of a tool in a hand, in addition to its public functions.
#pragma once

#include <cstdint>

#include "bone/grid/leaf_history.h"
#include "cut/effects/plan.h"
#include "cut/path_sim/internals.h"
#include "cut/removal/cutter.h"
#include "kerf/coupled.h"

namespace kerf {

/// Parameters with variants of the removal that studies and tests compare with kerf's own.
struct ComparedParams : CoupledParams {
  bool whole_voxel_removal = false;  // removes whole voxels at once, which causes steps in the force
  int precision_bits = 24;           // significand bits of the values that removal writes, 4 to 24: all bits of a float
};

/// Work of a simulation, for studies of speed.
struct StepWork {
  Cutter::Effort removal;     // of the last step
  std::uint64_t samples = 0;  // of the bone, by contact, so far
  int spare_leaves = 0;       // left
};

struct CoupledInternals {
  static CoupledSimulation Make(Bone bone, const ComparedParams& params, const Pose& X_WT_start);
  static EffectPlan& Effects(const CoupledSimulation& simulation);
  static StepWork Work(const CoupledSimulation& simulation);
  static Pose ToolPose(const CoupledSimulation& simulation);  // after the last tick, or at the start
  static void SupplyLeaves(CoupledSimulation& simulation, int least);
  static void ClearChanged(CoupledSimulation& simulation, int first);
  static LeafHistory& KeepHistory(CoupledSimulation& simulation, int ring_leaves);
  static LeafHistory* History(CoupledSimulation& simulation);
  static bool Checkpoint(CoupledSimulation& simulation, std::uint32_t number);
};

/// As the constructor of CoupledSimulation.
inline CoupledSimulation MakeComparedSimulation(Bone bone, const ComparedParams& params, const Pose& X_WT_start) {
  return CoupledInternals::Make(std::move(bone), params, X_WT_start);
}

/// Does what Refill() does, and provides at least `least` spare leaves. One thread other than that of the ticks may
/// call it at any time, also during a tick.
inline void SupplyLeaves(CoupledSimulation& simulation, int least = 0) {
  CoupledInternals::SupplyLeaves(simulation, least);
}

/// Removes the first of the changed leaves from their list; the order of the others may change. Tick-safe.
inline void ClearChanged(CoupledSimulation& simulation, int first) {
  CoupledInternals::ClearChanged(simulation, first);
}

/// State and results of the effects. Tick-safe to read.
inline EffectPlan& EffectsOf(CoupledSimulation& simulation) {
  return CoupledInternals::Effects(simulation);
}
inline const EffectPlan& EffectsOf(const CoupledSimulation& simulation) {
  return CoupledInternals::Effects(simulation);
}

/// Starts recording the previous values of changed leaves in a history. Its ring has room for `ring_leaves` leaves (2
/// kB each) that have not been read yet. Recording begins with checkpoint 0. Later calls return the same history.
inline LeafHistory& KeepHistory(CoupledSimulation& simulation, int ring_leaves = 8192) {
  return CoupledInternals::KeepHistory(simulation, ring_leaves);
}
/// Returns nullptr if no history is recorded. Tick-safe.
inline LeafHistory* HistoryOf(CoupledSimulation& simulation) {
  return CoupledInternals::History(simulation);
}
/// Records the current bone as a checkpoint that can be restored (restore.h). Later changes are recorded in the history
/// under `number`, 1 or more. Does nothing and returns false if the history ring is full or there is no history. Bone
/// that the tool has passed in slab mode, and that has not been removed yet, is removed after the checkpoint. Between
/// ticks; tick-safe.
inline bool MakeCheckpoint(CoupledSimulation& simulation, std::uint32_t number) {
  return CoupledInternals::Checkpoint(simulation, number);
}

}  // namespace kerf
