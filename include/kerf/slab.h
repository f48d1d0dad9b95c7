// Slab mode: the thin slice as a point mass on a rail, the cheap fallback when voxels are too slow. No grid in the
// tick.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/paper.h"
#include "kerf/simulation.h"
#include "kerf/tool.h"

namespace kerf {

/// What stands in the blade's way, by depth below the first bone that it meets. Made once, before the run.
struct SlabProfile {
  struct Layer {
    double top_mm = 0;  // depth where it begins; it ends where the next begins
    int region = 0;     // the one with the largest share of its area; 0: no bone
    double E_MPa = 0;   // means over its area; 0: no bone
    double nu = 0;
  };
  std::vector<Layer> layers;  // by depth, the first at 0
  double end_mm = 0;          // depth where the last ends: the slice's length; beyond it the slice is free
  double entry_mm = 0;        // coordinate along the cut direction, p_W . d, where depth is 0
  double slice_mm3 = 0;       // the slice's volume; 0 when it isn't known

  /// The layer at a depth, null outside 0..end_mm. O(log layers). Tick-safe.
  const Layer* Find(double depth_mm) const;
};

/// The paper's Table 2: depths of 3.75, 12.5, 18.75 and 26.25 mm for regions 24, 21, 13 and 6, read as the middles of
/// bands 0 - 7.5 - 17.5 - 20 - 32.5 mm (a reading; the paper does not say). E and nu from `materials`. `entry_mm` as
/// above. Throws Error when a region is missing.
SlabProfile MakePaperProfile(const MaterialTable& materials, double entry_mm);

/// The profile of the slice of `thickness_mm` about `plane`, by the bone's own surface and regions, looked at along
/// `direction_W` (unit, in the plane) in steps of a quarter of a voxel. Only bone within `reach_mm` of the plane's
/// point across the direction counts: what the disc can meet. Throws Error when no bone is there.
SlabProfile MakeBoneProfile(const Bone& bone, const CutPlane& plane, double thickness_mm, const Vec3& direction_W,
                            double reach_mm);

/// Which body the hand holds. kNone: it has let go.
enum class SlabBody { kSlice, kLeft, kRight, kNone };

/// The slice, its rail and its neighbours. Springs of 0 are no springs.
struct SlabParams {
  DiscSaw saw;
  Vec3 direction_W{0, 1, 0};                         // of the rail, unit length; the paper's is y
  PaperReading reading = PaperReading::kAsComputed;  // of the cutting resistance
  double contact_share_of_pitch = 0.01;              // a tooth's contact radius, above 0 to 0.5
  double mass_g = 1;                                 // of slice and blade, 0.001 to 10000
  double stiffness_N_per_mm = 0;                     // spring from the slice to where it began, 0 to 1e6
  double damping_Ns_per_mm = 0;                      // damper from the slice to the jaw, 0 to 1e3
  double friction_coefficient = 0;                   // of each of its two faces on the segments, 0 to 10
  double normal_force_N = 0;                         // on each face, 0 to 1e4
  double coupling_N_per_mm = 100;                    // spring from the hand to what it holds, 1e-3 to 1e6
  double coupling_damping_Ns_per_mm = 0.01;          // 0 to 1e3
  bool segments_move = false;                        // false: the jaw is held fast
  double segment_mass_g = 20;                        // of each; this and the next only when they move
  double segment_stiffness_N_per_mm = 1;             // to where each began
  double segment_damping_Ns_per_mm = 0.01;
};

/// Where things are and where the energy went. Displacements along the direction, mm; energies mJ (N mm), totals since
/// the start.
struct SlabState {
  double blade_mm = 0;  // displacement of blade and, once it is met, slice
  double left_mm = 0;
  double right_mm = 0;
  double depth_mm = 0;    // of the blade's edge below the first bone; < 0 before it
  double deepest_mm = 0;  // cut so far: above it there is no cutting resistance
  bool free = false;      // the slice has left the jaw
  bool sticking = false;  // at rest on both segments at the end of the tick
  double kinetic_mJ = 0;
  double elastic_mJ = 0;
  double hand_work_mJ = 0;
  double friction_mJ = 0;  // dissipated, each >= 0
  double cutting_mJ = 0;
  double damping_mJ = 0;
  double released_mJ = 0;   // what the slice's spring held when the slice came free
  double numerical_mJ = 0;  // dissipated by the time step
};

/// The slice between its segments.
///
/// Model:   bodies of one degree of freedom along the rail, m dv/dt = springs + dampers - interface forces. On each
/// face
///          of the slice acts, between -mu N and mu N, Coulomb friction, and half of the cutting resistance F(depth),
///          which only opposes going deeper than what has been cut. Both are set-valued at rest: the slice sticks as
///          long as they can hold it. With the spindle stopped the blade goes no deeper.
/// Step:    implicit Euler, each sub-step solved exactly (a monotone piecewise-linear equation), so nothing chatters
///          and no stiffness is too large. Energy balance, to rounding: kinetic + elastic = hand_work - friction -
///          cutting - damping - released - numerical, every loss >= 0.
/// Start:   set down inside the bone, the blade meets a slice that nobody has moved: its spring is slack there, and
/// what
///          lies above counts as cut. Set down past the slice's end it is free.
/// Valid:   motion of the hand along the rail; motion across it is not felt while the slice is on the rail.
/// Tick-safe: Tick() allocates nothing.
class SlabSimulation {
 public:
  /// The blade begins where X_WT_start holds it. Throws Error when a parameter is out of range, the profile's layers
  /// are not in order, or the blade starts past the slice.
  SlabSimulation(SlabProfile profile, const SlabParams& params, const Pose& X_WT_start);
  ~SlabSimulation();
  SlabSimulation(SlabSimulation&&) noexcept;
  SlabSimulation& operator=(SlabSimulation&&) noexcept;

  /// Moves the hand to in.X_WT and lets the bodies follow. In the output, means over the tick: f_T_W_N the force on the
  /// hand; thrust_sum_N the resistance that the law gives at this depth, engaged_teeth, mean_E_MPa and main_region what
  /// it rests on; mean_bite_mm and removed_mm3 are 0.
  TickOutput Tick(const TickInput& in);
  /// Lifts the blade out and sets it down at X_WT, at rest; what is cut stays cut. False, and nothing done, for a bad
  /// pose.
  bool SetDown(const Pose& X_WT);
  /// The hand lets go of what it holds and takes `body`, where both are, without a jolt.
  void Hold(SlabBody body);

  const SlabState& state() const;
  const SlabProfile& profile() const;
  std::uint64_t CalcMemoryBytes() const;  // profile, law and state

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
