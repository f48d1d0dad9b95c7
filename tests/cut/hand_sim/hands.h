// A saw, a block and hands for the coupled tool's tests.
#pragma once

#include <cmath>
#include <cstdlib>
#include <vector>

#include "kerf/coupled.h"
#include "support/cuts.h"

namespace kerf::test {

/// A disc over a block: in the block's frame the disc lies in the plane y = 0, and z is up (DiscPose).
///
/// The environment variable KERF_TEST_LAW selects another force law than the default, to try the tests with it
/// (docs/stability.md has the results).
inline CoupledParams DiscParams() {
  CoupledParams params;
  params.tool = DiscSaw{};
  if (const char* law = std::getenv("KERF_TEST_LAW")) params.law = ForceLaw(law);
  return params;
}

inline CoupledInput Handle(const Pose& X_WH, double rpm = 7500, double dt_s = 0.001) {
  CoupledInput in;
  in.X_WH = X_WH;
  in.rpm = rpm;
  in.dt_s = dt_s;
  return in;
}

/// A hand that moves the handle so far from the tool that the coupling gives `force_W` in each tick; the handle keeps
/// the orientation `R_WH`.
class PushingHand {
 public:
  PushingHand(CoupledSimulation& simulation, const Pose& X_WT_start) : simulation_(simulation), X_WT_(X_WT_start) {
    R_WH_ = X_WT_start.R_AB;
  }
  CoupledOutput Push(const Vec3& force_W, double rpm = 7500, double dt_s = 0.001) {
    const CouplingParams& c = simulation_.params().coupling;
    CoupledInput in = Handle({}, rpm, dt_s);
    in.X_WH.R_AB = R_WH_;
    const Vec3 C_W = X_WT_.Point(c.p_TC_mm) + force_W / c.stiffness_N_per_mm;
    in.X_WH.p_AB = C_W - in.X_WH.Vector(c.p_TC_mm);
    const CoupledOutput out = simulation_.Tick(in);
    X_WT_ = out.X_WT;
    return out;
  }
  const Pose& X_WT() const { return X_WT_; }
  Quat& R_WH() { return R_WH_; }

 private:
  CoupledSimulation& simulation_;
  Pose X_WT_;
  Quat R_WH_{1, 0, 0, 0};
};

}  // namespace kerf::test
