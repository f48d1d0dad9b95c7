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
};

/// The paper's Table 2: depths of 3.75, 12.5, 18.75 and 26.25 mm for regions 24, 21, 13 and 6, read as the middles of
/// bands 0 - 7.5 - 17.5 - 20 - 32.5 mm (a reading; the paper does not say). E and nu from `materials`. `entry_mm` as
/// above. Throws Error when a region is missing.
SlabProfile MakePaperProfile(const MaterialTable& materials, double entry_mm);

/// A plane through a bone, world frame. `normal_W` of unit length: from the left segment to the right one.
struct CutPlane {
  Vec3 p_W{0};
  Vec3 normal_W{1, 0, 0};
};

/// The profile of the slice of `thickness_mm` about `plane`, by the bone's own surface and regions, looked at along
/// `direction_W` (unit, in the plane). Only bone within `reach_mm` of the plane's point across the direction counts:
/// what the disc can meet. Throws Error when no bone is there.
SlabProfile MakeBoneProfile(const Bone& bone, const CutPlane& plane, double thickness_mm, const Vec3& direction_W,
                            double reach_mm);

/// Which body the hand holds.
enum class SlabBody { kSlice, kLeft, kRight };

struct SlabParams {
  DiscSaw saw;
  Vec3 direction_W{0, 1, 0};  // the rail, unit length; the paper's is y
  PaperReading reading = PaperReading::kAsComputed;
  double contact_share_of_pitch = 0.01;
  double mass_g = 1;                // of the slice
  double stiffness_N_per_mm = 0;    // spring from the slice to where it began
  double damping_Ns_per_mm = 0;     // damper from the slice to the world
  double friction_coefficient = 0;  // of each of its two faces on the segments
  double normal_force_N = 0;        // on each face
  double coupling_N_per_mm = 100;   // spring from the hand to what it holds
  double coupling_damping_Ns_per_mm = 0.01;
  bool segments_move = false;  // false: the jaw is held fast
  double segment_mass_g = 20;  // of each; the rest only when segments_move
  double segment_stiffness_N_per_mm = 1;
  double segment_damping_Ns_per_mm = 0.01;
};

/// Where things are and where the energy went. Displacements along the direction, mm; energies mJ (N mm).
struct SlabState {
  double slice_mm = 0, left_mm = 0, right_mm = 0;  // displacement since the start
  double depth_mm = 0;                             // of the blade's edge below the first bone; < 0 before it
  double deepest_mm = 0;                           // what was cut: no cutting resistance above it
  bool free = false;                               // the slice has left the jaw
  bool sticking = false;                           // slice at rest on both segments
  double kinetic_mJ = 0, elastic_mJ = 0;
  double hand_work_mJ = 0;                                                   // done by the hand
  double friction_mJ = 0, cutting_mJ = 0, damping_mJ = 0, numerical_mJ = 0;  // dissipated, each >= 0
};

/// The slice between its segments. Tick-safe: no allocation, lock, file or clock in Tick().
class SlabSimulation {
 public:
  /// Throws Error when a parameter is out of range.
  SlabSimulation(SlabProfile profile, const SlabParams& params, const Pose& X_WT_start);

  /// Moves the hand to in.X_WT and lets the bodies follow. In the output: f_T_W_N is the force on the hand;
  /// thrust_sum_N the law's resistance at this depth, engaged_teeth, mean_E_MPa and main_region what it rests on;
  /// removed_mm3 is 0.
  TickOutput Tick(const TickInput& in);
  bool SetDown(const Pose& X_WT);
  /// The hand lets go of what it holds and takes `body` where both are.
  void Hold(SlabBody body);
  const SlabState& state() const { return state_; }

 private:
  SlabState state_;
};

}  // namespace kerf
