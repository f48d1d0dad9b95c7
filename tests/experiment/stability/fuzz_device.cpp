#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/core/heap_guard.h"
#include "device/devices/profiles.h"
#include "device/devices/simulated_device.h"
#include "experiment/stability/fuzz_run.h"
#include "experiment/stability/invariants.h"
#include "loop/haptics/haptic_step.h"

namespace kerf::test {
namespace {

/// Device with prescribed samples and failures.
class FaultyDevice : public Device {
 public:
  explicit FaultyDevice(const DeviceProfile& profile) : profile_(profile) {}
  const DeviceProfile& profile() const override { return profile_; }
  bool Read(DeviceSample& sample) noexcept override {
    sample.X_WH = X_WH;
    return !read_fails;
  }
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override {
    f_N = f_H_W_N;
    tau_Nmm = tau_H_W_Nmm;
    return !write_fails;
  }

  Pose X_WH;
  bool read_fails = false;
  bool write_fails = false;
  Vec3 f_N{0}, tau_Nmm{0};

 private:
  DeviceProfile profile_;
};

/// Checks the forces that the motors receive in each tick.
class MotorWatch {
 public:
  MotorWatch(const DeviceProfile& profile, const ForceMapParams& map) : profile_(profile), map_(map) {
    slew_N_per_s_ = map.slew_N_per_s > 0 ? map.slew_N_per_s : profile.peak_force_N / 0.005;
    const bool turns = profile.degrees_of_freedom == 6 && profile.peak_torque_Nmm > 0;
    peak_Nmm_ = turns ? profile.peak_torque_Nmm : 0;
  }

  std::string Check(const HapticTick& out, double slew_dt_s) {
    const TickInputs& in = out.in;
    const Vec3 f = out.force.f_H_W_N;
    const Vec3 tau = out.force.tau_H_W_Nmm;
    if (!IsFinite(f) || !IsFinite(tau)) return "I1: the motors get an invalid force";
    if (std::hypot(f.x, f.y, f.z) > profile_.peak_force_N)
      return fmt::format("I2: the motors get {} N", glm::length(f));
    if (std::hypot(tau.x, tau.y, tau.z) > peak_Nmm_) return fmt::format("I2: the motors get {} N mm", glm::length(tau));
    const bool faulty = out.faults != kHapticOk;
    if (faulty && (f != Vec3(0) || tau != Vec3(0))) return "the device gets a force despite a fault";
    if (!faulty && !(in.dt_s >= 0 && in.dt_s <= 1)) return "an invalid time step caused no fault";
    if (!IsValid(out.X_WH) || !IsInWorld(out.X_WH.p_AB)) return "I1: a bad sample is kept";
    if (!IsFinite(out.v_H_W_mm_per_s)) return "I1: the handle's velocity is not finite";
    // After zero force, the force rises slowly; otherwise it changes at most at the slew rate. A falling thermal limit
    // may reduce it faster.
    const double dt = std::min({in.dt_s, slew_dt_s, 0.1});
    const double step = glm::length(f - last_f_N_);
    if (!faulty && glm::length(f) > glm::length(last_f_N_) && step > slew_N_per_s_ * dt * (1 + 1e-9)) {
      return fmt::format("I2: the force steps by {} N in {} s", step, dt);
    }
    since_fault_s_ = faulty ? 0 : since_fault_s_ + std::min(in.dt_s, 0.1);
    const double t = map_.ramp_in_s > 0 ? std::min(since_fault_s_ / map_.ramp_in_s, 1.0) : 1;
    if (glm::length(f) > (3 * t * t - 2 * t * t * t) * glm::length(out.coupled.f_H_W_N) * (1 + 1e-9) + 1e-12 &&
        !lagging_) {
      lagging_ = glm::length(f) <= glm::length(last_f_N_) + 1e-12;  // still decreasing
      if (!lagging_)
        return fmt::format("{} N out for {} N in, {} s after a fault", glm::length(f), glm::length(out.coupled.f_H_W_N),
                           since_fault_s_);
    }
    lagging_ = false;
    last_f_N_ = f;
    return "";
  }

 private:
  DeviceProfile profile_;
  ForceMapParams map_;
  double slew_N_per_s_;
  double peak_Nmm_;
  Vec3 last_f_N_{0};
  double since_fault_s_ = 0;
  bool lagging_ = false;
};

DeviceProfile MakeProfile(Dice& dice) {
  const auto& profiles = DeviceProfiles();
  DeviceProfile profile = profiles[static_cast<std::size_t>(dice.Below(static_cast<int>(profiles.size())))];
  if (!(profile.mass_kg > 0)) profile.mass_kg = 0.1;
  if (dice.OneIn(4)) profile.resolution_mm = dice.One({0.0, 1e-6, 0.5});
  return profile;
}

ForceMapParams MakeMap(Dice& dice) {
  ForceMapParams map;
  map.expected_peak_N = dice.One({28.0, 28.0, 0.1, 1e4});
  map.knee = dice.One({0.9, 0.1, 1.0});
  map.slew_N_per_s = dice.One({0.0, 0.0, 1.0, 1e7});
  map.ramp_in_s = dice.One({0.5, 0.5, 0.0, 0.01});
  map.thermal_s = dice.One({10.0, 0.1});
  return map;
}

HandModel MakeHand(Dice& dice) {
  if (dice.OneIn(4)) return HandModels()[static_cast<std::size_t>(dice.Below(static_cast<int>(HandModels().size())))];
  HandModel hand;
  hand.mass_kg = dice.LogUniform(0.02, 1);
  hand.damping_Ns_per_mm = dice.LogUniform(0.5e-3, 20e-3);
  hand.stiffness_N_per_mm = dice.OneIn(4) ? 0 : dice.LogUniform(1e-3, 1);
  hand.torsion_Nmm_per_rad = 1000;
  hand.torsion_damping_Nmms = 10;
  return hand;
}

}  // namespace

FuzzResult FuzzDevice(std::uint64_t seed, int calls, long& ticks) {
  Dice dice(seed);
  const FuzzScene scene = MakeFuzzScene(dice);
  FuzzHand fuzz_hand(dice, scene, 20);
  const DeviceProfile profile = MakeProfile(dice);
  const ForceMapParams map = MakeMap(dice);
  CoupledSimulation simulation = MakeComparedSimulation(scene.bone, scene.params, scene.start);
  HapticStep step(simulation, profile, map);
  MotorWatch motors(profile, map);
  const double volume_mm3 = scene.bone.CalcVolume();
  BoneWitness witness(scene.bone);

  const bool wild = dice.OneIn(2);
  FaultyDevice faulty_device(profile);
  SimulatedDeviceOptions options;
  options.p_TC_mm = scene.params.coupling.p_TC_mm;
  options.delay_ticks = dice.One({0, 0, 1, 5, 16});
  SimulatedDevice simulated(profile, MakeHand(dice), scene.start, options);
  Device& device = wild ? static_cast<Device&>(faulty_device) : simulated;

  FuzzResult result;
  Pose X_WT = scene.start;
  Box3 box;
  int failing = 0;
  for (; result.tick < calls && result.wrong.empty(); ++result.tick) {
    const FuzzCall call = fuzz_hand.Next(X_WT);
    if (call.kind == FuzzCall::Kind::kSetDown) simulation.SetDown(call.in.X_WH);
    if (call.kind == FuzzCall::Kind::kRefill) simulation.Refill();
    if (call.kind == FuzzCall::Kind::kSetDown && IsValid(call.in.X_WH) && IsInWorld(call.in.X_WH.p_AB))
      X_WT = call.in.X_WH;
    if (call.kind != FuzzCall::Kind::kTick) continue;
    // Faults start at random and last for some ticks.
    if (--failing < 0) {
      faulty_device.read_fails = faulty_device.write_fails = false;
      simulated.SetFaults({});
      if (dice.OneIn(40)) {
        failing = dice.Below(20);
        faulty_device.read_fails = dice.OneIn(2);
        faulty_device.write_fails = dice.OneIn(2);
        DeviceFaults faults;
        faults.frozen = dice.OneIn(3);
        faults.not_a_number = dice.OneIn(3);
        faults.read_fails = dice.OneIn(3);
        faults.write_fails = dice.OneIn(3);
        if (dice.OneIn(3)) faults.jump_mm = dice.LogUniform(0.01, 100) * dice.Direction();
        simulated.SetFaults(faults);
        simulated.SetHand(MakeHand(dice));
      }
    }
    faulty_device.X_WH = call.in.X_WH;
    if (IsValid(call.in.X_WH) && IsInWorld(call.in.X_WH.p_AB)) {
      simulated.SetIntention({.X_WH = call.in.X_WH, .push_W_N = dice.OneIn(4) ? 20.0 * dice.InCube() : Vec3(0)});
    }
    TickInputs in{.dt_s = call.in.dt_s, .rpm = call.in.rpm};
    if (dice.OneIn(200)) in.flags = kRecordedForceOff;
    const double slew_dt_s = dice.OneIn(4) ? 0.001 : std::numeric_limits<double>::infinity();
    step.set_slew_dt_s(slew_dt_s);
    const HeapUseCounter heap;
    HapticTick out;
    {
      const HeapGuard guard;
      out = step.Step(device, in);
    }
    ++ticks;
    if (heap.count() != 0) result.wrong = fmt::format("{} heap calls in the tick", heap.count());
    if (result.wrong.empty()) result.wrong = motors.Check(out, slew_dt_s);
    const bool ticked =
        (out.faults & (kHapticReadFailed | kHapticBadSample)) == 0 && (out.coupled.status & kCoupledBadPose) == 0;
    if (ticked) {
      for (const Box3& b :
           {CalcCutBox(scene.params.tool, X_WT, out.coupled.X_WT, out.coupled.substeps, scene.voxel_mm)}) {
        box.Include(b.lower);
        box.Include(b.upper);
      }
      X_WT = out.coupled.X_WT;
    }
  }
  if (!result.wrong.empty()) return result;
  double removed = 0;
  for (const double r : simulation.CalcRemovedByRegion()) removed += r;
  const Bone& bone = simulation.UpdateBone();
  if (!(std::abs(volume_mm3 - bone.CalcVolume() - removed) <= 1e-9 * volume_mm3)) {
    result.wrong = fmt::format("I4: {} mm3 at first, {} left, {} removed", volume_mm3, bone.CalcVolume(), removed);
    return result;
  }
  if (!box.empty()) witness.Allow(box);
  result.wrong = witness.Compare(bone);
  return result;
}

}  // namespace kerf::test
