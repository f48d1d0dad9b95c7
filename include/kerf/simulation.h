// Simulation step: moves the tool to a pose, removes bone, and returns a force. Uses no file, clock, thread or device.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/effects.h"
#include "kerf/force.h"
#include "kerf/geometry.h"
#include "kerf/observe.h"
#include "kerf/tool.h"

namespace kerf {

/// Parameters of a tool on a path; a coupled tool has these and more (CoupledParams).
struct SimulationParams {
  Tool tool = DiscSaw{};
  ForceLaw law;
  /// A scene uses exactly the effects that it enables. On a path, effects that need a coupled tool are omitted.
  EffectChoices effects{EffectChoice("kerf_friction")};
  int rim_samples_per_pitch = 16;
  int substeps = 1;
  int carve_interval_ticks = 1;  // src/cut/removal/paced_cutter.h
};

/// The numerical parameters that all ticks and [simulation] of a scene have.
template <typename Params, typename V>
void DescribeSampling(Params& p, V&& visit) {
  visit("rim_samples_per_pitch", p.rim_samples_per_pitch, Range{1, 256},
        "number of edge points per tooth pitch at which bone is looked up along the rim");
  visit("substeps", p.substeps, Range{1, 64}, "minimum number of substeps per tick");
}
template <typename Params, typename V>
void DescribeCarving(Params& p, V&& visit) {
  visit("carve_interval_ticks", p.carve_interval_ticks, Range{1, 64},
        "ticks between two removals of bone; bone is removed sooner when the tool has moved a quarter of a voxel");
}
template <typename V>
void Describe(SimulationParams& p, V&& visit) {
  DescribeSampling(p, visit);
  DescribeCarving(p, visit);
}

/// Ticks per second of a scene and of a loop. A tick may be shorter or longer (TickInput::dt_s).
inline constexpr Range kTickRateRange_hz{250, 4000};

/// Shortest tick in which anything happens.
inline constexpr double kMinTick_s = 1e-6;

struct TickInput {
  Pose X_WT;            // tool pose at the end of the tick
  double dt_s = 0.001;  // 0 or more; below 1e-6 the tick does nothing and repeats the last force
  double rpm = 7500;    // spindle speed; sign: direction about +z; |rpm| < kMinRpm: stopped, the tool does not cut
};

/// Bits of TickOutput::status. Each comment states what the tick did instead of what was requested. Recordings contain
/// these bits and those of CoupledStatus, so both keep their numbers.
enum TickStatus : std::uint32_t {
  kTickOk = 0,
  kTickBadPose = 1u << 0,  // pose, rpm or dt not finite or out of range: nothing is done, the force is zero, and the
                           // last valid pose is kept
  kTickSpindleStopped = 1u << 1,   // |rpm| < kMinRpm: the tool is moved, nothing is cut, and the force is zero
  kTickSubstepsLimited = 1u << 2,  // the motion needs more than the maximum number of substeps: the steps along the
                                   // path are coarser
  kTickNoTime = 1u << 3,           // dt below kMinTick_s: nothing is done, the last force is repeated
  kTickTouchesMetal = 1u << 4,     // the path leads through metal, which is not cut and gives no force
};

/// What the teeth did in a tick of a tool on a path or of a coupled tool. Forces are means over the tick, but those for
/// the work of the teeth are means over their way: with a stroke, a tooth is fast where its bite is large.
struct TeethOutput {
  double thrust_sum_N = 0;   // sum of the magnitudes of the teeth's thrust
  double thrust_W = 0;       // sum of thrust times speed of the teeth along their motion
  double cutting_sum_N = 0;  // sum of the teeth's cutting forces, mean over their way; 0 unless the law states one
  double cutting_W = 0;      // power of these forces at the speed of the teeth; 0 likewise
  double engaged_teeth = 0;  // engaged arc / pitch, a real number
  double mean_E_MPa = 0;     // over the engaged teeth; 0 if none
  double mean_bite_mm = 0;   // over the engaged teeth
  int main_region = 0;       // region id with the largest part of thrust_sum_N; 0 if no tooth is engaged
  double removed_mm3 = 0;    // from voxel occupancy: decrease of the sum of clamp(1/2 - phi/h, 0, 1) h^3
  std::uint32_t status = 0;  // TickStatus or CoupledStatus
};

/// Output of a tick. Vectors are in the world frame. Forces act on the tool and are means over the tick.
struct TickOutput : TeethOutput {
  Vec3 f_T_W_N{0};       // force on the tool
  Vec3 tau_TG_W_Nmm{0};  // torque on the tool about the grip
};

/// Simulation of a bone and a tool that follows a prescribed path.
class Simulation {
 public:
  /// Throws kerf::Error if a parameter is out of range, the law has no forces for a tissue of the bone, or X_WT_start
  /// is not a valid pose within the world.
  Simulation(Bone bone, const SimulationParams& params, const Pose& X_WT_start);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Moves the tool to in.X_WT and removes what it sweeps. Deterministic: the same calls give bit-identical results.
  /// Allocates only if thousands of leaves have changed since the last Refill(). Throws only as kerf/own_effect.h says.
  TickOutput Tick(const TickInput& in, TickObserver* observer = nullptr);

  /// Moves the tool to X_WT without cutting on the way. Does nothing and returns false if the pose is invalid.
  bool SetDown(const Pose& X_WT);

  /// The leaves that have changed since the last ClearChanged().
  int changed_count() const;
  ChangedLeaf changed(int i) const;
  void ClearChanged();

  // ---- between ticks: to take a piece of bone out or to restore it (src/bone/grid/piece_removal.h)
  /// Returns true if the tool is too far from the box for a change in it to affect the next tick.
  bool IsClearOf(const Box3& bounds_W) const;
  /// Changes the leaf's 512 values from `from` to `to`; voxels that have been cut since stay cut. Does nothing and
  /// returns false if no spare leaf is left.
  bool Replace(const std::array<int, 3>& index, const float* from, const float* to);
  /// Adds sign * mm3 to the volumes taken out, by region; `sign` is 1, or -1 when bone is restored. These volumes do
  /// not count as removed.
  void AddTakenOut(const std::array<double, 256>& mm3, double sign);

  // ---- results of the effects
  /// Returns their names, such as "heat.peak_C"; docs/effects.md describes them.
  std::vector<std::string> ListChannels() const;
  /// Writes their values after the last tick, in the same order; `values` must have that size. Tick-safe.
  void ReadChannels(std::span<double> values) const;

  // ---- outside the tick
  /// Removes what is still to be removed and returns the current bone.
  const Bone& UpdateBone();
  /// Computes the volume removed so far, by region id, mm^3. The sum equals the decrease of the bone's volume up to
  /// rounding, excluding pieces taken out. Index 0: bone without a region.
  std::array<double, 256> CalcRemovedByRegion();
  Bone TakeBone() &&;
  /// Reserves memory for the leaves that the next ticks change. A tick that runs out of leaves allocates more.
  void Refill();

 private:
  friend struct SimulationInternals;  // for kerf's own sources
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
