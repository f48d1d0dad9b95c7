// Invariants of every tick and of the end of a run, for any hand, device and bone.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "base/core/vectors.h"
#include "cut/contact/step.h"
#include "experiment/stability/bone_watch.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "loop/haptics/haptic_step.h"

namespace kerf::test {

/// Checks the inputs and outputs of a coupled simulation, tick by tick. Construct it before the first tick:
///
///   Invariants invariants(simulation, X_start);
///   ... invariants.Tick(in, out);             // after each tick; or Step() after each HapticStep
///   ... invariants.CheckBone();               // at the end, or at intervals
///
/// A violation makes the test fail. It is reported once per invariant, with the tick and the figure.
///
///   I1 all values are finite
///   I2 spring and damper stay within their limits; the device's force never exceeds its peak, to the last bit, nor
///      its slew rate
///   I3 without contact there is no force, and the tool is at the handle
///   I4 to I7: see BoneWatch
///   I15 the energies of the tick balance; dissipated energy is never negative; the sums since the start never fall
///      below the limits that coupled.h states
///   I7 between two look-ups of the bone the tool moves at most half a voxel, or a quarter of the disc's thickness or
///      of a voxel along the spindle
///   I17 the force on the hand is the sum of the spring's force between the output poses and the damper's force at the
///      speeds of handle and tool; the forces on the other side of the tool are equally large
class Invariants {
 public:
  struct Options {
    bool watch_bone = true;  // if false, CheckBone() does nothing: for very long runs
    bool report = true;      // violations fail the test; if false, they are only in violations()
  };
  Invariants(CoupledSimulation& simulation, const Pose& X_WT_start, const Options& options);
  Invariants(CoupledSimulation& simulation, const Pose& X_WT_start)
      : Invariants(simulation, X_WT_start, Options{true, true}) {}

  /// Sets the device that receives the forces, for Step().
  void WatchDevice(const DeviceProfile& profile, const ForceMapParams& force_map = {});

  void Tick(const CoupledInput& given, const CoupledOutput& out);
  /// `slew_dt_s`: as in HapticStep.
  void Step(const HapticTick& out, double slew_dt_s = std::numeric_limits<double>::infinity());
  /// Must be called after the simulation's SetDown().
  void SetDown(const Pose& X_WT);
  /// Checks the simulation's bone (I4 to I7). The simulation passed to the constructor must be the one that ran the
  /// ticks.
  void CheckBone();

  /// The first violation of each invariant.
  const std::map<std::string, std::string>& violations() const { return violations_; }
  bool ok() const { return violations_.empty(); }

  std::int64_t ticks() const { return ticks_; }
  double removed_mm3() const { return removed_mm3_; }  // sum over the ticks
  double largest_force_N() const { return largest_force_N_; }
  double hand_mJ() const { return hand_mJ_; }
  double spindle_mJ() const { return spindle_mJ_; }
  double stored_mJ() const { return stored_mJ_; }
  double lost_mJ() const { return lost_mJ_; }  // cutting + friction + numerical loss

 private:
  void Fail(const std::string& invariant, const std::string& what);
  bool CheckFinite(const CoupledOutput& out);
  void CheckBounds(const CoupledInput& in, const CoupledOutput& out);
  void CheckAir(const CoupledInput& in, const CoupledOutput& out);
  void CheckForce(const CoupledInput& in, const CoupledOutput& out);
  void CheckStep(const CoupledInput& in, const CoupledOutput& out);
  void CheckEnergy(const CoupledInput& in, const CoupledOutput& out);
  Bending FindBending(const Pose& X_WH) const;
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
  bool slab_ = false;  // true after any tick with the slab's law: its bone is removed later
  double removed_mm3_ = 0;
  double removed_since_check_mm3_ = 0;
  double largest_force_N_ = 0;
  double hand_mJ_ = 0, spindle_mJ_ = 0, stored_mJ_ = 0, lost_mJ_ = 0, max_mJ_ = 0;
  bool turning_reported_ = true;  // false for a HapticStep, which does not report the handle's rate of rotation
  double set_down_mJ_ = 0;        // energy that setting down stored in the springs

  struct Watched {
    DeviceProfile profile;
    ForceMapParams force_map;
    Vec3 f_N{0};
    Vec3 tau_Nmm{0};
  };
  std::optional<Watched> device_;
  std::map<std::string, std::string> violations_;
};

/// Checks a tool on a path in the same way: I1, I3 to I7, and that forces resist the motion.
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
