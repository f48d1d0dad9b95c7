// What must hold in every tick and at the end, whatever hand, device and bone do.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "experiment/stability/bone_watch.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "loop/haptics/haptic_step.h"

namespace kerf::test {

/// Looks at what goes into a coupled simulation and what comes out, tick by tick. Make it before the first tick:
///
///   Invariants invariants(simulation, X_start);
///   ... invariants.Tick(in, out);             // after each tick; or Step() after each HapticStep
///   ... invariants.CheckBone();               // at the end, or now and then
///
/// What does not hold is a failure of the test, told once for each invariant with the tick and the figure.
///
///   I1 all is finite
///   I2 spring and damper give no more than their limits; the device no more than its peak, to the last bit, and no
///      more change than its slew
///   I3 nothing touched: no force, and the tool is where the handle is
///   I4 to I7: see BoneWatch
///   I15 the energy of the tick closes; what is lost for good is never negative; the sums since the start never fall
///      below what coupled.h promises
///   I7 in one look at the bone the tool goes half a voxel at most, or a quarter of disc or voxel along the spindle
///   I17 the force on the hand is the spring's between the poses that were given out and the damper's at the speed that
///      the handle and the tool had, and what holds the tool from the other side is as large
class Invariants {
 public:
  struct Options {
    bool watch_bone = true;  // else CheckBone() does nothing: for very long runs
    bool report = true;      // failures of the test; else only in violations()
  };
  Invariants(CoupledSimulation& simulation, const Pose& X_WT_start, const Options& options);
  Invariants(CoupledSimulation& simulation, const Pose& X_WT_start)
      : Invariants(simulation, X_WT_start, Options{true, true}) {}

  /// The device that the forces go to, for Step().
  void WatchDevice(const DeviceProfile& profile, const ForceMapParams& force_map = {});

  void Tick(const CoupledInput& in, const CoupledOutput& out);
  void Step(const HapticStepInput& in, const HapticStepOutput& out);
  /// The simulation was told to SetDown() there.
  void SetDown(const Pose& X_WT);
  /// The simulation is in the same state as when this was made anew: not, say, an output of it.
  void CheckBone();

  /// By invariant, the first of its kind.
  const std::map<std::string, std::string>& violations() const { return violations_; }
  bool ok() const { return violations_.empty(); }

  std::int64_t ticks() const { return ticks_; }
  double removed_mm3() const { return removed_mm3_; }  // by the ticks
  double largest_force_N() const { return largest_force_N_; }
  double hand_mJ() const { return hand_mJ_; }
  double spindle_mJ() const { return spindle_mJ_; }
  double stored_mJ() const { return stored_mJ_; }
  double lost_mJ() const { return lost_mJ_; }  // cut + friction + numerical

 private:
  void Fail(const std::string& invariant, const std::string& what);
  bool CheckFinite(const CoupledOutput& out);
  void CheckBounds(const CoupledInput& in, const CoupledOutput& out);
  void CheckAir(const CoupledInput& in, const CoupledOutput& out);
  void CheckForce(const CoupledInput& in, const CoupledOutput& out);
  void CheckStep(const CoupledInput& in, const CoupledOutput& out);
  void CheckEnergy(const CoupledInput& in, const CoupledOutput& out);
  double CalcCouplingEnergy(const Pose& X_WT, const Pose& X_WH) const;

  CoupledSimulation& simulation_;
  CoupledParams params_;
  Options options_;
  double h_;
  std::unique_ptr<BoneWatch> watch_;
  Pose X_WT_;
  Pose X_WH_;
  Vec3 f_H_W_N_{0};
  Vec3 tau_H_W_Nmm_{0};
  std::int64_t ticks_ = 0;
  bool slab_ = false;  // any of it has been done by the slab's law: removed later
  double removed_mm3_ = 0;
  double removed_since_check_mm3_ = 0;
  double largest_force_N_ = 0;
  double hand_mJ_ = 0, spindle_mJ_ = 0, stored_mJ_ = 0, lost_mJ_ = 0, most_mJ_ = 0;
  bool turning_told_ = true;  // a HapticStep does not tell the handle's turning rate
  double set_down_mJ_ = 0;    // what setting down drew the springs by

  struct Watched {
    DeviceProfile profile;
    ForceMapParams force_map;
    Vec3 f_N{0};
    Vec3 tau_Nmm{0};
  };
  std::optional<Watched> device_;
  std::map<std::string, std::string> violations_;
};

/// The same for a tool on a path: I1, I3 to I7, and forces that resist.
class PathInvariants {
 public:
  PathInvariants(Simulation& simulation, const SimulationParams& params, const Pose& X_WT_start, bool report = true);
  void Tick(const TickInput& in, const TickOutput& out);
  void SetDown(const Pose& X_WT) { X_WT_ = X_WT; }
  void CheckBone();
  const std::map<std::string, std::string>& violations() const { return violations_; }
  double removed_mm3() const { return removed_mm3_; }

 private:
  void Fail(const std::string& invariant, const std::string& what);

  Simulation& simulation_;
  SimulationParams params_;
  bool report_;
  BoneWatch watch_;
  Pose X_WT_;
  std::int64_t ticks_ = 0;
  double removed_mm3_ = 0;
  double removed_since_check_mm3_ = 0;
  std::map<std::string, std::string> violations_;
};

}  // namespace kerf::test
