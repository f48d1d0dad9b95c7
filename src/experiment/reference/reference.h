// The cut computed slowly and independently of the simulation: no grid, all in double precision. The bone is a formula
// minus the exact sweeps of the disc; the rim is an integral. The errors of the simulation are measured against this.
//
// It is the limit of the model (docs/physics.md, docs/tick.md) for vanishing voxels, samples and steps, without
// effects. It shares with the simulation only the force laws and the tool's parameters, which are part of the model and
// not of its solution (the tests repeat the closed forms of the laws). It does not share the engagement, the sweep or
// the solver. Lengths that equal a voxel in the simulation are parameters here, which tend to 0: the look-ahead, and,
// for a tool coupled to a handle, the zone of the rim that cuts. Both in the simulation and in the reference, the
// amount of bone that this zone removes sideways (if a disc is set down in bone, or a hand trembles across the kerf)
// depends on the zone's width.
#pragma once

#include <atomic>
#include <functional>
#include <vector>

#include "experiment/reference/exact_bone.h"
#include "kerf/coupling.h"
#include "kerf/force.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Resolution of the computation. It converges in each parameter: the error falls with the lengths and with the
/// inverses of the counts.
struct ReferenceFineness {
  int rim_points = 1536;  // the ends of engaged pieces are located between them
  int steps_per_tick = 4;
  double flat_spacing_mm = 0.7;
  double look_ahead_mm = 1e-5;  // larger than rounding and an arc's sagitta
  double edge_mm = 0.3;         // the walls act on the flats inside it; at most half the tool's radius
};
template <typename V>
void Describe(ReferenceFineness& p, V&& visit) {
  visit("rim_points", p.rim_points, Range{16, 1 << 20}, "number of points evenly around the rim");
  visit("steps_per_tick", p.steps_per_tick, Range{1, 1 << 16},
        "steps of equal length; more if any point would move further than 0.025 mm in one step (on a path: if the tool "
        "would move further than 0.1 mm)");
  visit("flat_spacing_mm", p.flat_spacing_mm, Range{0.01, 10}, "distance of the points on the flats");
  visit("look_ahead_mm", p.look_ahead_mm, Range{1e-8, 0.1}, "bone this far ahead of the rim is engaged");
  visit("edge_mm", p.edge_mm, Range{1e-3, 50}, "with a hand: width of the rim that cuts");
}

struct ReferenceParams {
  DiscSaw saw;
  ForceLaw law;
  double rpm = 7500;
  double tick_s = 0.001;
  CouplingParams coupling;  // kHand only
  ReferenceFineness fineness;
  /// Ticks in which the tool is lifted out and set down, given by the index of the pose at their end, ascending. They
  /// have no motion, force or cutting.
  std::vector<std::size_t> set_downs;
};

template <typename V>
void Describe(ReferenceParams& p, V&& visit) {
  visit("rpm", p.rpm, Range{-kMaxRpm, kMaxRpm}, "speed of the spindle");
  visit("tick_s", p.tick_s, Range{1e-6, 1}, "duration of a tick");
}

/// State at the end of a tick, as in the simulation's outputs. World frame.
struct ReferenceTick {
  Pose X_WT;
  Vec3 f_W_N{0};  // on a path: on the tool, mean over the tick; with a hand: on the hand, at the end of the tick
  double thrust_sum_N = 0;
  double engaged_teeth = 0;
  // Volume removed since the start. In the last tick this is the volume that the bone has lost,
  // ExactBone::CalcRemoved(). In earlier ticks it is proportional to the flux of uncut bone through the rim and (on a
  // path) the flats, which misses strips narrower than 0.5 mm that a flat removes.
  double removed_mm3 = 0;
};

struct ReferenceRun {
  std::vector<ReferenceTick> ticks;  // one fewer than the poses
  ExactBone bone;                    // at the end
};

/// Moves the tool along the poses regardless of resistance. X_WT[0] is the start and X_WT[k] the end of tick k; between
/// poses the tool moves straight and rotates uniformly. The whole disc removes bone. Throws Error in the tick after
/// `*stop` has become true.
ReferenceRun RunReferenceOnPath(ExactSolid solid, const ReferenceParams& params, const std::vector<Pose>& X_WT,
                                const std::atomic<bool>* stop = nullptr);

/// Moves the handle along the poses, with the tool coupled to it. Only the rim removes bone (the model of docs/tick.md,
/// solved by another method). `stop` as above.
ReferenceRun RunReferenceInHand(ExactSolid solid, const ReferenceParams& params, const std::vector<Pose>& X_WH,
                                const std::atomic<bool>* stop = nullptr);

}  // namespace kerf
