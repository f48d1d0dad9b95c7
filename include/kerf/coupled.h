// Coupled simulation: a spring and a damper connect the tool to a handle, and the bone resists the tool. The input is a
// handle pose; the output is a force on the hand. Uses no file, clock, thread or device.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kerf/coupling.h"
#include "kerf/paper.h"
#include "kerf/simulation.h"

namespace kerf {

/// Fidelity of a tick, most accurate first. Each level is cheaper than the one before.
enum class Fidelity : std::uint8_t {
  kFull,    // all edge and flat points, the whole band
  kCoarse,  // every second point, at most a quarter of max_substeps
  kSlab,    // for a rotating disc that is cutting: the slab force law in the disc's plane, without reading or removing
            // bone. Bone that the tool has passed is removed when the fidelity rises again. Otherwise as kCoarse.
};
const char* ToString(Fidelity fidelity);

struct CoupledParams : SimulationParams {
  CouplingParams coupling = {};
  int max_iterations = 40;
  int max_substeps = 24;
  int spare_leaves = 4096;
  PaperReading slab_reading = PaperReading::kCorrected;  // arc and tooth count that determine the slab's
                                                         // resistance at a depth
};
template <typename V>
void Describe(CoupledParams& p, V&& visit) {
  Describe(static_cast<SimulationParams&>(p), visit);
  visit("max_iterations", p.max_iterations, Range{1, 1000}, "maximum number of iterations of the solver in a substep");
  visit("max_substeps", p.max_substeps, Range{1, 4096}, "maximum number of substeps per tick");
  visit("spare_leaves", p.spare_leaves, Range{0, 1 << 24}, "leaves in reserve for bone that is cut; see BoneField");
}

struct CoupledInput {
  Pose X_WH;               // pose of the handle: the desired pose of the tool frame
  Vec3 v_H_W_mm_per_s{0};  // measured velocity of the coupling point, each component up to 1e6; unused without damping
  Vec3 w_H_W_rad_per_s{0};
  // 0 to 1; other values are bad input. Below 1e-6 the tick does nothing and repeats the last forces.
  double dt_s = 0.001;
  double rpm = 7500;  // spindle speed, within kMaxRpm and CalcRateRange(), stopped if |rpm| < 1; sign: direction of
                      // rotation about +z
};

/// Bits of CoupledOutput::status. Each comment states the condition and, where it applies, what the tick did instead.
enum CoupledStatus : std::uint32_t {
  kCoupledOk = 0,
  kCoupledBadPose = 1u << 0,  // handle pose, velocity, dt or rpm not finite or out of range: nothing is done, the force
                              // is zero, and the last valid pose is kept
  kCoupledSubstepsUsedUp =
      1u << 1,  // the tool could not complete its motion in this tick: it lags behind and continues in the next tick
  kCoupledIterationsUsedUp = 1u << 2,  // the solver reached its iteration limit with a motion that still lowers the
                                       // energy: less accurate, but passive
  kCoupledForceLimited = 1u << 3,      // the coupling reached its force or torque limit
  kCoupledLeavesUsedUp = 1u << 4,      // no spare leaf left: the tool was stopped in front of uncut bone
  kCoupledAsleep = 1u << 5,            // no bone is near: the tool is at the handle
  kCoupledSpindleStopped = 1u << 6,    // the spindle is stopped: the edge does not cut and acts as a solid contact
  kCoupledBlending = 1u << 7,          // transition between two fidelities
  kCoupledNoTime = 1u << 8,            // dt below 1e-6 s: nothing is done, the last forces are repeated
  kCoupledTouchesMetal = 1u << 9,      // the turning edge rests on metal, which it does not cut
};

/// Output of a tick. Vectors are in the world frame. Forces on the tool are means over the tick.
struct CoupledOutput : TeethOutput {
  Pose X_WT;            // pose of the tool
  Vec3 f_H_W_N{0};      // force on the hand, at the coupling point
  Vec3 tau_H_W_Nmm{0};  // torque on the hand about the coupling point
  Vec3 f_cut_W_N{0};    // on the tool, from the edge
  Vec3 f_face_W_N{0};   // on the tool: normal forces on its flats and, with the spindle stopped, on its edge
  Vec3 f_friction_W_N{0};
  /// Regions in which a tooth cut, one bit per id. A layer one voxel thick in the region grid is detected even if its
  /// force is small. Excludes bone that the tool passed in slab mode.
  std::array<std::uint64_t, 4> regions_cut{};
  bool HasCut(int region) const {
    return region >= 0 && region < 256 && (regions_cut[region / 64] >> (region % 64) & 1) != 0;
  }
  // Energies of this tick, mJ = N mm: hand + spindle = stored + cut + friction + damping + numerical.
  // hand_mJ: work of the hand on the coupling. In the model the handle moves first, with the tool fixed, and the tool
  // then follows. The work is the energy that the springs gain while the handle moves. In air the work is 0.
  double hand_mJ = 0;
  // Work of the spindle on the tool's motion: friction on the flats can drive the tool, which may then push the hand.
  // Excludes the spindle power that rubbing turns into heat.
  double spindle_mJ = 0;
  double stored_mJ = 0;  // energy gained by the springs of the coupling and of contact
  double cut_mJ = 0;     // cut, friction and damping are >= 0
  double friction_mJ = 0;
  double damping_mJ = 0;
  // Energy that the springs lose because substeps have finite length: their energy at the start of the tick plus the
  // energy put into them, minus their energy at its end and minus the work of the forces that they have at the ends of
  // the substeps. It is computed independently of the other terms, so the balance above closes to solver accuracy. It
  // is negative when uneven bone pushes a point of a flat out, which uses up earlier losses: the losses to cutting, to
  // friction and to the steps, summed since the start, are never negative.
  double numerical_mJ = 0;
  int substeps = 0;
  int iterations = 0;  // maximum over the substeps
  Fidelity fidelity = Fidelity::kFull;
  double displacement_mm = 0;  // of an edge with a stroke, along itself, at the end of the tick
};

/// Simulation of a bone, the tool in it, and the coupling to a handle.
///
/// Model: the tool has no mass. In each substep its motion u (linear and angular velocity) is the unique minimiser of a
/// convex function: energy of the coupling at the end of the substep + dissipation of the damper, of cutting
/// (docs/physics.md) and of friction + unilateral contact of the flats and, with the spindle stopped, of the edge.
///
/// Guarantees: the solution is unique for any stiffness and step. Cutting, contact and friction never return energy,
/// except for the energy that the spindle adds through friction. The tool never passes through bone.
class CoupledSimulation {
 public:
  /// Throws kerf::Error if a parameter is out of range or X_WT_start is not a valid pose within the world.
  CoupledSimulation(Bone bone, const CoupledParams& params, const Pose& X_WT_start);
  ~CoupledSimulation();
  CoupledSimulation(CoupledSimulation&&) noexcept;
  CoupledSimulation& operator=(CoupledSimulation&&) noexcept;

  /// Runs one tick. Deterministic: the same calls give bit-identical results. Tick-safe: allocates nothing and never
  /// blocks. Throws only as kerf/own_effect.h says.
  CoupledOutput Tick(const CoupledInput& in, TickObserver* observer = nullptr);

  /// Moves the tool to X_WT without cutting on the way. Does nothing and returns false if the pose is invalid.
  /// Tick-safe.
  bool SetDown(const Pose& X_WT);
  /// Sets the fidelity. The change takes effect over the next ticks, without a jump in the force. Tick-safe.
  void SetFidelity(Fidelity fidelity);
  Fidelity fidelity() const;

  /// The leaves that have changed since the last ClearChanged(). Tick-safe.
  int changed_count() const;
  ChangedLeaf changed(int i) const;
  void ClearChanged();

  // ---- results of the effects
  /// Returns their names, such as "heat.peak_C"; docs/effects.md describes them.
  std::vector<std::string> ListChannels() const;
  /// Writes their values after the last tick, in the same order; `values` must have that size. Tick-safe.
  void ReadChannels(std::span<double> values) const;

  // ---- between ticks, tick-safe: to take a piece of bone out or to restore it (src/cut/hand_sim/take_out.h)
  /// Returns true if the tool is too far from the box for a change in it to affect the next tick.
  bool IsClearOf(const Box3& bounds_W) const;
  /// Changes the leaf's 512 values from `from` to `to`; voxels that have been cut since stay cut. Does nothing and
  /// returns false if no spare leaf is left.
  bool Replace(const std::array<int, 3>& index, const float* from, const float* to);
  /// Adds sign * mm3 to the volumes taken out, by region; `sign` is 1, or -1 when bone is restored. These volumes do
  /// not count as removed.
  void AddTakenOut(const std::array<double, 256>& mm3, double sign);

  // ---- outside the tick
  /// Restores the initial reserve of spare leaves. Must be called during a cut that needs more leaves than this
  /// reserve; otherwise the tool stops in front of uncut bone (kCoupledLeavesUsedUp) and waits.
  void Refill();
  const CoupledParams& params() const;
  /// Computes the volume cut since the start, by region, mm^3. The sum is exactly the decrease of the bone's volume,
  /// excluding pieces taken out.
  std::array<double, 256> CalcRemovedByRegion();
  /// Removes what is still to be removed (also what the tool has passed in slab mode) and returns the current bone.
  const Bone& UpdateBone();
  Bone TakeBone() &&;
  std::size_t CalcMemoryBytes() const;  // of everything except the bone

 private:
  friend class Restore;  // for kerf's own sources, as the next
  friend struct CoupledInternals;
  CoupledSimulation() noexcept;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
