// The saw in a hand: a tool tied to the handle by a spring and a damper, which the bone holds back. A handle pose in, a
// force on the hand out. No file, clock, thread or device.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "kerf/bone.h"
#include "kerf/effects.h"
#include "kerf/force.h"
#include "kerf/geometry.h"
#include "kerf/observe.h"
#include "kerf/paper.h"
#include "kerf/tool.h"

namespace kerf {

class EffectPlan;
class LeafHistory;

/// Spring and damper between handle and tool, at one point of the tool. A device's profile limits them.
struct CouplingParams {
  Vec3 p_TC_mm{0};  // the point, tool frame: the grip for a device that also senses and turns, the tool's own
                    // origin for one with forces only
  double stiffness_N_per_mm = 1;      // 1e-3 to 1e3
  double damping_Ns_per_mm = 0;       // 0 to 1; against the velocity that is given with the handle
  double torsion_Nmm_per_rad = 5000;  // 1 to 1e7
  double torsion_damping_Nmms = 0;    // N mm s / rad, 0 to 1e4
  double max_force_N = 40;            // spring and damper give no more each, however far the handle goes; 0.1 to 1e4
  double max_torque_Nmm = 4000;       // likewise; 1 to 1e6
};

/// How exactly a tick is worked out, most exact first. Each step down is cheaper.
enum class Fidelity : std::uint8_t {
  kFull,    // all edge and face points, all of the band
  kCoarse,  // every second point, a quarter of the sub-steps
  kSlab,    // a disc in a cut, turning: the thin slab's law on the disc's plane, nothing looked up or removed; what the
            // tool passed is removed on the way back. Anything else: as kCoarse.
};
const char* ToString(Fidelity fidelity);

struct CoupledParams {
  Tool tool;
  ForceLaw law;
  CouplingParams coupling;
  EffectChoices effects{EffectChoice("kerf_friction")};  // a scene's are those that it names, and no others
  int edge_samples_per_pitch = 16;                       // 1 to 256
  int max_iterations = 40;                               // of the solver in a sub-step, 1 to 1000
  int max_substeps = 24;                                 // in a tick, 1 to 4096
  bool whole_voxel_removal = false;  // for comparison: voxels go all at once, with the force steps that this makes
  int spare_leaves = 4096;           // see BoneField
  PaperReading slab_reading = PaperReading::kCorrected;  // by which the slab's resistance goes with depth
  int substeps = 1;  // so many equal parts of a tick at least, over which the handle goes on evenly, 1 to 64
  int carve_interval_ticks = 1;  // bone is removed every so many ticks, 1 to 64 (src/cut/removal/paced_cutter.h)
  int precision_bits = 24;       // for comparison: of the significand of what removal writes, 4 to 24 (a float's)
};

struct CoupledInput {
  Pose X_WH;               // handle: where the hand wants the tool frame
  Vec3 v_H_W_mm_per_s{0};  // of the coupling point, as measured; 0 when the coupling has no damping
  Vec3 w_H_W_rad_per_s{0};
  // 0 to 1; below 1e-6 nothing is done and the force stays as it was, outside it is a bad input
  double dt_s = 0.001;
  double rpm = 7500;  // spindle; below 1 stopped. Its sign is the direction of turning, about +z
};

/// Bits of CoupledOutput::status. Each says what was done instead.
enum CoupledStatus : std::uint32_t {
  kCoupledOk = 0,
  kCoupledBadPose = 1u << 0,  // handle pose, velocity, dt or rpm not finite or out of range: nothing done, zero force,
                              // last good pose held
  kCoupledSubstepsUsedUp =
      1u << 1,  // the tool could not get as far as the solution in this tick: it lags behind, and goes on next tick
  kCoupledIterationsUsedUp =
      1u
      << 2,  // the solver stopped at its bound with a motion that still lowers the energy: less accurate, never active
  kCoupledForceLimited = 1u << 3,    // the coupling gave its greatest force or torque
  kCoupledLeavesUsedUp = 1u << 4,    // no spare leaf left: the tool was stopped before uncut bone
  kCoupledAsleep = 1u << 5,          // nothing near: the tool is where the handle is
  kCoupledSpindleStopped = 1u << 6,  // rpm = 0: the edge does not cut, it is a solid contact
  kCoupledBlending = 1u << 7,        // between two fidelities
  kCoupledNoTime = 1u << 8,          // dt below 1e-6 s: nothing done, the last tick's forces given again
};

/// Vectors in the world frame.
struct CoupledOutput {
  Pose X_WT;            // the tool
  Vec3 f_H_W_N{0};      // force on the hand, at the coupling point
  Vec3 tau_H_W_Nmm{0};  // torque on the hand about the coupling point
  Vec3 f_cut_W_N{0};    // on the tool: from the edge
  Vec3 f_face_W_N{0};   // from faces and stopped edge, normal part
  Vec3 f_friction_W_N{0};
  double thrust_sum_N = 0;
  double engaged_teeth = 0;
  double mean_E_MPa = 0;
  double mean_bite_mm = 0;
  int main_region = 0;
  /// Regions in which a tooth cut, one bit by id: a layer of one voxel of the region grid is not missed, however little
  /// force it makes. Without what the slab's law passed.
  std::array<std::uint64_t, 4> regions_cut{};
  bool HasCut(int region) const {
    return region >= 0 && region < 256 && (regions_cut[region / 64] >> (region % 64) & 1) != 0;
  }
  double removed_mm3 = 0;  // by occupancy of voxels: docs/physics.md
  // Energy in this tick, mJ = N mm: hand + spindle = stored + cut + friction + damping + numerical.
  // By the hand on the coupling. The handle is taken to move first, with the tool held, and the tool then to follow:
  // the work is what the springs gain in the first part. While nothing is touched both move as one, and it is 0.
  double hand_mJ = 0;
  // From the spindle into the tool's motion, where the faces' friction helps it along: may push the hand. What rubbing
  // makes into heat of the spindle's own power is not counted.
  double spindle_mJ = 0;
  double stored_mJ = 0;  // gained by the springs of coupling and contact
  double cut_mJ = 0;     // >= 0, as the next two
  double friction_mJ = 0;
  double damping_mJ = 0;
  // Lost by the springs to steps of finite length: what they held and were given, less what they hold now and the work
  // of their forces at the ends of the steps. Counted without the other terms, so that the sum above closes to the
  // solver's accuracy. Below 0 when uneven bone pushes a face out, which takes of what was lost before: cut + friction
  // + numerical, summed since the start, is never below 0.
  double numerical_mJ = 0;
  int substeps = 0;
  int iterations = 0;  // most in one sub-step
  Fidelity fidelity = Fidelity::kFull;
  std::uint32_t status = kCoupledOk;
};

/// The bone, the tool in it and the coupling.
///
/// Model: the tool has no mass. In each sub-step its motion u (velocity and turning rate) is the one minimiser of a
/// convex
///        function: energy of the coupling at the end + dissipation of the damper, of cutting (docs/physics.md) and of
///        friction + unilateral contact of faces and, with the spindle stopped, of the edge.
/// Holds: one solution for any stiffness and step; cutting, contact and friction never return energy, but for what the
///        spindle puts in through friction; the tool never passes through bone.
class CoupledSimulation {
 public:
  /// Throws Error when a parameter is out of range.
  CoupledSimulation(Bone bone, const CoupledParams& params, const Pose& X_WT_start);
  ~CoupledSimulation();
  CoupledSimulation(CoupledSimulation&&) noexcept;
  CoupledSimulation& operator=(CoupledSimulation&&) noexcept;

  /// One step. Deterministic: the same calls give the same bits. Tick-safe: allocates nothing, waits for nothing.
  CoupledOutput Tick(const CoupledInput& in, TickObserver* observer = nullptr);

  /// Sets the tool down at X_WT without cutting on the way. False, and nothing done, for a bad pose. Tick-safe.
  bool SetDown(const Pose& X_WT);
  /// Takes effect over the next ticks, without a step in the force. Tick-safe.
  void SetFidelity(Fidelity fidelity);
  Fidelity fidelity() const;

  /// Leaves changed since ClearChanged(). Tick-safe.
  int changed_count() const;
  ChangedLeaf changed(int i) const;
  void ClearChanged();

  // ---- between ticks, tick-safe: bone is taken out and put back (src/cut/hand_sim/take_out.h)
  /// Whether nothing in the box is so near that a change of it could be felt within a tick.
  bool IsClearOf(const Box3& bounds_W) const;
  /// Where the leaf's values (512) are `from` they become `to`; what was cut since stays cut. False, and nothing done,
  /// when no leaf is left for it.
  bool Replace(const std::array<int, 3>& index, const float* from, const float* to);
  /// By region; below 0: put back. It is not counted as removed.
  void AddTakenOut(const std::array<double, 256>& mm3, double sign);

  // ---- undo, between ticks, tick-safe; putting bone back: src/cut/hand_sim/restore.h
  /// The bone as it is now can be come back to: what changes from here on is told to the history under this number, 1
  /// or more. False, and nothing done, when the history's ring is full or there is no history. What the slab's law
  /// passed and had not removed yet is removed later.
  bool Checkpoint(std::uint32_t number);

  // ---- not in the tick
  /// From now on what leaves were before they change goes to a history (src/bone/grid/leaf_history.h), whose ring holds
  /// `ring_leaves` (2 kB each) until somebody reads it; begins with a checkpoint of number 0. Once: later calls give
  /// the same history.
  LeafHistory& KeepHistory(int ring_leaves = 8192);
  /// Null: none is kept. Tick-safe.
  LeafHistory* history();
  /// Sets spare leaves aside again, as many as at the start. A long cut that the start did not allow for needs it, or
  /// the tool stops before uncut bone (kCoupledLeavesUsedUp) and waits.
  void Refill();
  const CoupledParams& params() const;
  /// What they keep and give (src/cut/effects/plan.h). Tick-safe to read.
  const EffectPlan& effects() const;
  EffectPlan& effects();
  /// Volume cut since the start by region, mm^3: exactly bone().CalcVolume()'s loss, but for what was taken out.
  std::array<double, 256> CalcRemovedByRegion();
  const Bone& bone();  // as it is now, without what the slab's law passed and had not removed yet
  Bone TakeBone() &&;
  std::size_t CalcMemoryBytes() const;  // of everything but the bone

 private:
  friend class Restore;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
