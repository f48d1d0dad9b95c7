// Slab mode: models the thin slice as a point mass on a rail. It is a cheap fallback for when voxels are too slow. Its
// tick uses no grid.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "kerf/bone.h"
#include "kerf/describe.h"
#include "kerf/geometry.h"
#include "kerf/paper.h"
#include "kerf/simulation.h"
#include "kerf/tool.h"

namespace kerf {

/// Material in front of the blade, by depth below the first bone that the blade touches. Computed once, before the run.
struct SlabProfile {
  struct Layer {
    double top_mm = 0;  // depth at which the layer begins; it ends where the next one begins
    int region = 0;     // region with the largest area; 0: no bone
    double E_MPa = 0;   // mean over the layer's area; 0: no bone
    double nu = 0;
  };
  std::vector<Layer> layers;  // in order of depth; the first begins at 0
  double end_mm = 0;          // length of the slice: depth at which the last layer ends and the slice is free
  double entry_mm = 0;        // coordinate of depth 0 along the cut direction d: p_W . d
  double slice_mm3 = 0;       // volume of the slice; 0 if unknown

  /// Returns the layer at a depth, or nullptr outside 0..end_mm. O(log layers). Tick-safe.
  const Layer* Find(double depth_mm) const;
};

/// Returns the profile of the paper's Table 2: depths of 3.75, 12.5, 18.75 and 26.25 mm for regions 24, 21, 13 and 6,
/// read as the middles of the bands 0 - 7.5 - 17.5 - 20 - 32.5 mm (an interpretation; the paper does not say). E and nu
/// are from `materials`. `entry_mm`: as in SlabProfile. Throws kerf::Error if a region is missing.
SlabProfile MakePaperProfile(const MaterialTable& materials, double entry_mm);

/// Computes the profile of a slice from the bone's surface and regions. The slice is `thickness_mm` thick and centred
/// on `plane`. It is sampled along `direction_W` (unit length, in the plane) in steps of a quarter of a voxel. Only the
/// bone that the disc can touch is included: the bone within `reach_mm` of the plane's point, measured across the
/// direction. Throws kerf::Error if there is no bone.
SlabProfile MakeBoneProfile(const Bone& bone, const CutPlane& plane, double thickness_mm, const Vec3& direction_W,
                            double reach_mm);

/// Body that the hand holds. kNone: the hand holds nothing.
enum class SlabBody { kSlice, kLeft, kRight, kNone };

/// Parameters of the slice, its rail and the segments next to it. A stiffness of 0 disables a spring.
struct SlabParams {
  DiscSaw saw;
  Vec3 direction_W{0, 1, 0};                         // direction of the rail, world frame, unit length; y in the paper
  PaperReading reading = PaperReading::kAsComputed;  // reading that gives the cutting resistance
  double contact_share_of_pitch = 0.01;
  double mass_g = 1;
  double stiffness_N_per_mm = 0;
  double damping_Ns_per_mm = 0;
  double friction_coefficient = 0;
  double normal_force_N = 0;
  double coupling_N_per_mm = 100;
  double coupling_damping_Ns_per_mm = 0.01;
  bool segments_move = false;
  double segment_mass_g = 20;
  double segment_stiffness_N_per_mm = 1;
  double segment_damping_Ns_per_mm = 0.01;
};

/// The slice and the hand; then the segments.
template <typename V>
void DescribeSlice(SlabParams& p, V&& visit) {
  visit("contact_share_of_pitch", p.contact_share_of_pitch, Range{1e-6, 0.5},
        "contact radius of a tooth as a fraction of the tooth pitch; the paper's is 0.01");
  visit("mass_g", p.mass_g, Range{0.001, 10000}, "mass of the slice and the blade");
  visit("stiffness_N_per_mm", p.stiffness_N_per_mm, Range{0, 1e6},
        "stiffness of the spring between the slice and its initial position");
  visit("damping_Ns_per_mm", p.damping_Ns_per_mm, Range{0, 1000}, "damping between the slice and the jaw");
  visit("friction_coefficient", p.friction_coefficient, Range{0, 10},
        "friction coefficient of each face of the slice on its segment; no measured value for bone on bone was found");
  visit("normal_force_N", p.normal_force_N, Range{0, 10000}, "normal force on each face of the slice");
  visit("coupling_N_per_mm", p.coupling_N_per_mm, Range{0.001, 1e6},
        "stiffness of the spring between the hand and the body that it holds; a desktop device renders 0.4 to 5");
  visit("coupling_damping_Ns_per_mm", p.coupling_damping_Ns_per_mm, Range{0, 1000},
        "damping between the hand and the body that it holds");
}
template <typename V>
void DescribeSegments(SlabParams& p, V&& visit) {
  visit("segments_move", p.segments_move, "true: the two segments also slide along the direction");
  visit("segment_mass_g", p.segment_mass_g, Range{0.001, 10000}, "mass of each segment, if the segments move");
  visit("segment_stiffness_N_per_mm", p.segment_stiffness_N_per_mm, Range{0, 1e6},
        "stiffness of the spring between each segment and its initial position, if the segments move");
  visit("segment_damping_Ns_per_mm", p.segment_damping_Ns_per_mm, Range{0, 1000},
        "damping between each segment and its initial position, if the segments move");
}
template <typename V>
void Describe(SlabParams& p, V&& visit) {
  DescribeSlice(p, visit);
  DescribeSegments(p, visit);
}

/// Positions and energies. Displacements are along the direction, mm. Energies are totals since the start, mJ (N mm).
struct SlabState {
  double blade_mm = 0;  // displacement of the blade and, once the two are in contact, of the slice
  double left_mm = 0;
  double right_mm = 0;
  double depth_mm = 0;    // of the blade's edge below the first bone; < 0 in front of it
  double deepest_mm = 0;  // largest depth cut so far: at smaller depths there is no cutting resistance
  bool free = false;      // the slice has left the jaw
  bool sticking = false;  // at rest relative to both segments at the end of the tick
  double kinetic_mJ = 0;
  double elastic_mJ = 0;
  double hand_work_mJ = 0;
  double friction_mJ = 0;  // dissipated; friction, cutting and damping are each >= 0
  double cutting_mJ = 0;
  double damping_mJ = 0;
  double released_mJ = 0;   // energy of the slice's spring when the slice came free
  double numerical_mJ = 0;  // dissipated by the time step
};

/// Simulation of the slice between its segments.
///
/// Model: bodies with one degree of freedom along the rail, m dv/dt = springs + dampers - interface forces. Two forces
/// act on each face of the slice: Coulomb friction, between -mu N and mu N, and half of the cutting resistance
/// F(depth), which opposes motion only beyond the depth already cut. Both are set-valued at rest: the slice sticks as
/// long as they can hold it. With the spindle stopped, the blade does not advance.
///
/// Integration: implicit Euler. The equation of each substep is monotone and piecewise linear, and is solved exactly.
/// The integration is therefore stable for any stiffness and does not chatter. Energy balance, up to rounding:
/// kinetic + elastic = hand_work - friction - cutting - damping - released - numerical, and every loss is >= 0.
///
/// Start: if the blade starts inside the bone, the slice is not displaced, its spring is slack at that position, and
/// the bone above counts as cut. If SetDown() places the blade beyond the end of the slice, the slice is free.
///
/// Validity: motion of the hand along the rail. Motion across it has no effect while the slice is on the rail.
///
/// Tick-safe: Tick() allocates nothing.
class SlabSimulation {
 public:
  /// The blade starts at X_WT_start. Throws kerf::Error if a parameter is out of range, the profile layers are not in
  /// order, the pose is invalid, or the blade starts past the slice.
  SlabSimulation(SlabProfile profile, const SlabParams& params, const Pose& X_WT_start);
  ~SlabSimulation();
  SlabSimulation(SlabSimulation&&) noexcept;
  SlabSimulation& operator=(SlabSimulation&&) noexcept;

  /// Moves the hand to in.X_WT and simulates the bodies over the tick. In the output, f_T_W_N is the force on the hand,
  /// a mean over the tick. thrust_sum_N is the resistance that the law gives at the current depth; engaged_teeth,
  /// mean_E_MPa and main_region are the inputs of the law. mean_bite_mm and removed_mm3 are 0.
  TickOutput Tick(const TickInput& in);
  /// Moves the blade to X_WT, at rest, without cutting on the way. Does nothing and returns false if the pose is
  /// invalid.
  bool SetDown(const Pose& X_WT);
  /// Makes the hand release its body and hold `body`, both at their current positions, without a jump in the force.
  void Hold(SlabBody body);

  const SlabState& state() const;
  const SlabProfile& profile() const;
  std::uint64_t CalcMemoryBytes() const;  // of profile, law and state

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
