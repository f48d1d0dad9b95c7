// Simulations that check the invariants in every tick.
#pragma once

#include <utility>

#include "cut/hand_sim/hands.h"
#include "experiment/stability/invariants.h"

namespace kerf::test {

/// A tool that is coupled to a handle.
struct WatchedTool {
  WatchedTool(Bone bone, const CoupledParams& params, const Pose& X_WT_start)
      : simulation(std::move(bone), params, X_WT_start), invariants(simulation, X_WT_start), X_WT(X_WT_start) {}

  CoupledOutput Tick(const Pose& X_WH, double rpm = 7500, double dt_s = 0.001) { return Tick(Handle(X_WH, rpm, dt_s)); }
  CoupledOutput Tick(const CoupledInput& in) {
    const CoupledOutput out = simulation.Tick(in);
    invariants.Tick(in, out);
    X_WT = out.X_WT;
    return out;
  }
  /// Runs a tick with the handle at the distance from the tool at which the coupling gives this force.
  CoupledOutput Push(const Quat& R_WH, const Vec3& force_W, double rpm = 7500, double dt_s = 0.001) {
    const CouplingParams& c = simulation.params().coupling;
    Pose X_WH{R_WH, Vec3(0)};
    X_WH.p_AB = X_WT.Point(c.p_TC_mm) + force_W / c.stiffness_N_per_mm - X_WH.Vector(c.p_TC_mm);
    return Tick(X_WH, rpm, dt_s);
  }
  /// Returns the exact volume removed since the start.
  double CalcRemoved() {
    double sum = 0;
    for (const double v : simulation.CalcRemovedByRegion()) sum += v;
    return sum;
  }

  CoupledSimulation simulation;
  Invariants invariants;
  Pose X_WT;
};

/// A tool on a path.
struct WatchedPath {
  WatchedPath(Bone bone, const SimulationParams& params, const Pose& X_WT_start)
      : simulation(std::move(bone), params, X_WT_start), invariants(simulation, params, X_WT_start) {}

  TickOutput Tick(const Pose& X_WT, double rpm = 7500, double dt_s = 0.001) {
    const TickInput in{X_WT, dt_s, rpm};
    const TickOutput out = simulation.Tick(in);
    invariants.Tick(in, out);
    return out;
  }
  double CalcRemoved() {
    double sum = 0;
    for (const double v : simulation.CalcRemovedByRegion()) sum += v;
    return sum;
  }

  Simulation simulation;
  PathInvariants invariants;
};

}  // namespace kerf::test
