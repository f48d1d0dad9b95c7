// The cut worked out slowly and independently of the simulation: no grid, all in double precision. The bone is a
// formula less the exact places where the disc has been; the rim is an integral. Against this the simulation's errors
// are measured.
//
// It is the limit of the model (docs/physics.md, docs/tick.md) for voxels, samples and steps of no size, without
// effects. With the simulation it shares the force laws and the tool's figures, which are the model and not a way of
// working it out (their closed forms are spelt out again in the tests), and nothing else: not the engagement, nor the
// sweep, nor the solver. What in the simulation is a voxel's is a length here that tends to 0: the look-ahead, and the
// zone of the rim that cuts in a hand. What that zone takes sideways (a disc set down in bone, a hand that trembles
// across the kerf) goes with its width in both.
#pragma once

#include <atomic>
#include <functional>
#include <vector>

#include "experiment/reference/exact_bone.h"
#include "kerf/force.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// How a hand holds the tool: the quantities of CouplingParams (kerf/coupled.h), which says what they mean.
struct ReferenceCoupling {
  Vec3 p_TC_mm{0};
  double stiffness_N_per_mm = 1;
  double damping_Ns_per_mm = 0;
  double torsion_Nmm_per_rad = 5000;
  double torsion_damping_Nmms = 0;
  double max_force_N = 40;
  double max_torque_Nmm = 4000;
};

/// How finely it is worked out. All of it converges: the error falls with each figure's own (the counts' inverses).
struct ReferenceFineness {
  int rim_points = 1536;  // evenly around the rim; ends of what is engaged are found between them
  int steps_per_tick =
      4;  // of equal length; more where any point of it would go further than 0.025 mm (led: the tool 0.1 mm) in one
  double flat_spacing_mm = 0.7;  // of the points on the flats
  double look_ahead_mm = 1e-5;   // so far ahead of the rim bone is engaged; above rounding and an arc's sagitta
  double edge_mm = 0.3;          // hand: of the rim that cuts; the walls hold all of the flats inside it
};

struct ReferenceParams {
  DiscSaw saw;
  ForceLaw law;
  double rpm = 7500;
  double tick_s = 0.001;
  ReferenceCoupling coupling;  // hand only
  ReferenceFineness fineness;
  /// Ticks, by the index of the pose at which they end, rising, in which the tool is lifted out and set down at that
  /// pose: no motion, no force, no cutting.
  std::vector<std::size_t> set_downs;
};

/// At the end of a tick, as the simulation's outputs. World frame.
struct ReferenceTick {
  Pose X_WT;
  Vec3 f_W_N{0};  // on a path: on the tool, mean over the tick; in a hand: on the hand, at the end of the tick
  double thrust_sum_N = 0;
  double engaged_teeth = 0;
  // Since the start. In the last tick what the bone has lost, ExactBone::CalcRemoved(); before it in proportion to the
  // flux of uncut bone through rim and (on a path) flats, which misses where a flat takes a strip narrower than a mm/2.
  double removed_mm3 = 0;
};

struct ReferenceRun {
  std::vector<ReferenceTick> ticks;  // one less than poses
  ExactBone bone;                    // as it is at the end
};

/// The tool goes along the poses, whatever stands in its way: X_W[0] is where it starts, X_W[k] where tick k ends;
/// between them it goes straight and turns evenly. The whole disc removes bone. Throws Error in the tick after `*stop`
/// has become true.
ReferenceRun RunReferenceOnPath(ExactSolid solid, const ReferenceParams& params, const std::vector<Pose>& X_WT,
                                const std::atomic<bool>* stop = nullptr);

/// The handle goes along the poses; the tool is tied to it, and the rim alone removes bone (docs/tick.md: the same
/// model, solved by other means). `stop` as above.
ReferenceRun RunReferenceInHand(ExactSolid solid, const ReferenceParams& params, const std::vector<Pose>& X_WH,
                                const std::atomic<bool>* stop = nullptr);

}  // namespace kerf
