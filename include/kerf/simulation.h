// The simulation step: a pose in, a force out, and a bone with a little less in it. No file, clock, thread or device.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "kerf/bone.h"
#include "kerf/effects.h"
#include "kerf/force.h"
#include "kerf/geometry.h"
#include "kerf/observe.h"
#include "kerf/tool.h"

namespace kerf {

struct SimulationParams {
  Tool tool = DiscSaw{};
  ForceLaw law;
  int rim_samples_per_pitch = 16;  // 1 to 256; how finely the rim looks for bone
  EffectChoices effects = {};      // those that need a hand are left out
  int substeps = 1;                // each tick in at least so many steps, 1 to 64
  int carve_interval_ticks = 1;    // ticks between two removals of bone, 1 to 64 (src/cut/removal/paced_cutter.h)
};

class EffectPlan;

/// A shorter time is none.
inline constexpr double kLeastTick_s = 1e-6;

struct TickInput {
  Pose X_WT;            // the tool at the end of the tick
  double dt_s = 0.001;  // 0 or more; below 1e-6 nothing is done and the force stays as it was
  double rpm = 7500;    // spindle speed; 0: stopped, does not cut
};

/// Bits of TickOutput::status. Each says what was done instead.
enum TickStatus : std::uint32_t {
  kTickOk = 0,
  kTickBadPose = 1u << 0,  // pose or dt not finite or out of range: nothing done, zero force, last good pose kept
  kTickSpindleStopped = 1u << 1,   // rpm = 0: the tool moved, nothing was cut, zero force
  kTickSubstepsLimited = 1u << 2,  // the tool jumped further than max sub-steps resolve: coarser steps along the path
  kTickNoTime = 1u << 3,           // dt below kLeastTick_s: nothing done, the last tick's force given again
};

/// All vectors in the world frame. Forces are forces on the tool, means over the tick.
struct TickOutput {
  Vec3 f_T_W_N{0};           // force on the tool
  Vec3 tau_TG_W_Nmm{0};      // torque on the tool about the grip
  double thrust_sum_N = 0;   // sum of the tooth forces' magnitudes
  double engaged_teeth = 0;  // engaged arc / pitch, a real number
  double mean_E_MPa = 0;     // over the engaged teeth; 0 when none
  double mean_bite_mm = 0;   // over the engaged teeth
  int main_region = 0;       // region id with the largest share of thrust_sum_N; 0 when no tooth is engaged
  double removed_mm3 = 0;    // by occupancy of voxels: sum of clamp(1/2 - phi/h, 0, 1) h^3 before less after
  std::uint32_t status = kTickOk;
};

/// The bone, the saw in it, and the last pose.
class Simulation {
 public:
  /// Throws Error when a parameter is out of range.
  Simulation(Bone bone, const SimulationParams& params, const Pose& X_WT_start);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Moves the tool to in.X_WT and cuts what it sweeps. Deterministic: the same calls give the same bits. Allocates
  /// only where Refill() has been put off for thousands of leaves.
  TickOutput Tick(const TickInput& in, TickObserver* observer = nullptr);

  /// Lifts the tool out and sets it down at X_WT, cutting nothing on the way. False, and nothing done, for a bad pose.
  bool SetDown(const Pose& X_WT);

  /// Leaves changed since ClearChanged().
  int changed_count() const;
  ChangedLeaf changed(int i) const;
  void ClearChanged();

  // ---- between ticks: bone is taken out and put back (src/bone/grid/piece_removal.h)
  /// Whether nothing in the box is so near that a change of it could be felt within a tick.
  bool IsClearOf(const Box3& bounds_W) const;
  /// Where the leaf's values (512) are `from` they become `to`; what was cut since stays cut. False, and nothing done,
  /// when no leaf is left for it.
  bool Replace(const std::array<int, 3>& index, const float* from, const float* to);
  /// By region; below 0: put back. It is not counted as removed.
  void AddTakenOut(const std::array<double, 256>& mm3, double sign);

  // ---- not in the tick
  /// What they keep and give (src/cut/effects/plan.h).
  const EffectPlan& effects() const;
  EffectPlan& effects();
  const Bone& bone() const;
  /// Removed volume so far by region id, mm^3, exactly what bone().CalcVolume() has lost up to rounding, but for what
  /// was taken out; index 0: where no region was given.
  std::array<double, 256> CalcRemovedByRegion();
  Bone TakeBone() &&;
  /// Sets memory aside for the bone that the ticks to come will open. A tick that finds none left asks for more itself.
  void Refill();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
