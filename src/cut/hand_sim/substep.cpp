// A substep: the tool moves towards the handle until bone that it meets or cuts must be found again.
#include <algorithm>
#include <cmath>

#include "cut/contact/broken_rule.h"
#include "cut/hand_sim/state.h"

namespace kerf {
namespace {

constexpr double kFlatStiffness_N_per_mm = 3000;   // of each point of a flat
constexpr double kSolidStiffness_N_per_mm = 2000;  // for a stopped edge: see CalcSolidStiffness()
constexpr double kStepVoxels = 0.5;                // maximum motion of the tool in a substep, in voxels
constexpr double kAxialFraction = 0.25;            // along the spindle, in voxels or thicknesses of a thinner disc
constexpr double kLargestTurn_rad = 0.5;
constexpr double kMarginVoxels = 1.5;  // bone within this distance is near

/// Returns the number of parts into which a motion must be divided so that each is at most `max_length` long. The
/// straight part of a motion is inversely proportional to the number of parts, and the bend is inversely proportional
/// to the square of that number.
double CountSteps(double straight, double bent, double max_length) {
  return (straight + std::sqrt(straight * straight + 4 * bent * max_length)) / (2 * max_length);
}

/// Returns the stiffness of each point of a stopped edge, N/mm. The stiffness of an eighth of a disc's pitch, or of one
/// part in 512 of a ball, does not depend on the number of points.
double CalcSolidStiffness(const ToolShape& shape) {
  double parts = 512;
  if (shape.edge_form == EdgeForm::kRing) parts = std::max(64.0, 8 * shape.passes_per_turn);
  if (shape.edge_form == EdgeForm::kChain) {
    parts = std::max(64.0, 8 * shape.edge.front().teeth * static_cast<double>(shape.edge.size()));
  }
  return kSolidStiffness_N_per_mm * parts / static_cast<double>(shape.edge.size());
}

}  // namespace

/// Resets all contact: nothing holds the tool.
void CoupledSimulation::State::Release() {
  u = {};
  if (contact_mJ > 0) edge.Release();
  faces.Release();
  effects.Release();
  contact_mJ = guide_mJ = effects_mJ = 0;
  f_cut_T = Vec3(0);
  teeth = 0;
}

/// Moves the tool towards the handle as far as there is certainly no bone.
CoupledSimulation::State::Flight CoupledSimulation::State::Fly(const CoupledInput& in, CoupledOutput& out) {
  const double margin_mm = kMarginVoxels * h;
  if (clearance.IsNear(X_WT, margin_mm)) return Flight::kNear;
  const double free_mm = clearance.bound_mm() - margin_mm;
  const double travel_mm = CalcTravel(X_WT, in.X_WH, shape.reach_mm);
  const bool arrives = travel_mm <= free_mm;
  if (effects.Holds({X_WT, in.X_WH})) return Flight::kNear;
  if (!arrives && free_mm < kStepVoxels * h) return Flight::kNear;  // shorter than a step
  CutWaiting(out);
  Release();
  EndSlab();
  X_WT = arrives ? in.X_WH : Interpolate(X_WT, in.X_WH, free_mm / travel_mm);
  coupling_mJ = coupling.CalcEnergy(X_WT, X_WH);
  return arrives ? Flight::kArrived : Flight::kUnderWay;
}

/// Moves the tool and updates the energies of the springs. `fraction`: completed part of the step that the problem was
/// set up for.
void CoupledSimulation::State::Move(const Pose& X_next, double fraction) {
  X_WT = X_next;
  coupling_mJ = coupling.CalcEnergy(X_WT, X_WH);
  if (problem.empty()) return;
  contact_mJ = edge.Remember(problem, u, fraction) + faces.Remember(problem, u, fraction);
  // These energies are for the straight motion of the step. On an arc the guide may be deflected further; the next
  // Engage() includes this.
  guide_mJ = CalcSolidsEnergy(first_guide, first_of_effects, fraction);
  effects_mJ = CalcSolidsEnergy(first_of_effects, problem.solids.size(), fraction);
  contact_mJ += guide_mJ + effects_mJ;
}

double CoupledSimulation::State::CalcSolidsEnergy(std::size_t first, std::size_t end, double fraction) const {
  double energy_mJ = 0;
  for (std::size_t i = first; i < end; ++i) {
    const SolidPoint& p = problem.solids[i];
    const double depth_mm = std::max(0.0, p.depth_mm + fraction * problem.tau_s * Dot(p.row, u));
    energy_mJ += 0.5 * p.stiffness_N_per_mm * depth_mm * depth_mm;
  }
  return energy_mJ;
}

/// Sets the motion of the blade over the time of a step that begins now. A stopped stroke keeps its place.
void CoupledSimulation::State::Stroke(const CoupledInput& in, double time_s) {
  if (in.rpm == 0) {
    const double slide_mm = drive.CalcDisplacement(phase_rad);
    stroke = {{slide_mm, slide_mm}, slide_mm};
  } else {
    stroke = drive.CalcStep(phase_rad, in.rpm, time_s, tick_s);
    problem.edge_mm_per_s = stroke.speed_mm_per_s;
  }
  edge.SetDisplacement(stroke.middle_mm);
  faces.SetDisplacement(stroke.middle_mm);
}

/// Sets up the problem of a step at the tool's pose.
void CoupledSimulation::State::Engage(const CoupledInput& in, double time_s, TickObserver* observer) {
  const Probe probe(field, EdgePose());
  problem.Clear();
  problem.tau_s = time_s;
  problem.coupling = coupling.MakeStep(X_WT, in);
  const bool turning = in.rpm != 0;
  // Largest motion of a face towards the bone in a step.
  const double reach_mm = is_blade ? kAxialFraction * std::min(h, CalcThickness(params.tool)) : kStepVoxels * h;
  const bool reads_bone = bone_fraction > 0;
  const double stiffness_fraction = bone_fraction * (fidelity == Fidelity::kFull ? 1 : 2);
  problem.cutting_share = bone_fraction;
  problem.flat_stiffness_N_per_mm = stiffness_fraction * kFlatStiffness_N_per_mm;
  if (!reads_bone) {
    edge.Release();
    faces.Release();
    effects.Release();
  } else if (turning) {
    edge.FindTeeth(probe, problem);
    if (edge.needs_solids()) {
      edge.FindSolidsWhileCutting(probe, (kStepVoxels + kAxialFraction) * h, bone_fraction * CalcSolidStiffness(shape),
                                  problem);
    }
  } else {
    edge.FindSolids(probe, (kStepVoxels + kAxialFraction) * h, bone_fraction * CalcSolidStiffness(shape), problem);
  }
  if (faces.size() > 0 && reads_bone) {
    faces.Find(probe, reach_mm, turning, problem);
  }
  first_guide = problem.solids.size();
  double drawn_mJ = 0;
  if (slab.active()) {
    // A spring that becomes stiffer while the slab law takes over must not push the tool back by itself.
    drawn_mJ = slab.CalcEnergy(X_WT, 1 - bone_fraction);
    if (drawn_mJ - guide_mJ > reserve_mJ + 1e-12 * guide_mJ) {
      slab.Anchor(X_WT);
      drawn_mJ = 0;
    }
    slab.AddTo(X_WT, 1 - bone_fraction, problem);
  }
  first_of_effects = problem.solids.size();
  {
    const EffectsStage stage(observer, effects, TickStage::kEngage);
    effects.Engage({X_WT, probe, edge, &faces, in.rpm, reads_bone, StrokeOrNull(), {}, reserve_mJ}, problem);
  }
  if (problem.empty()) return;
  drawn_mJ += CalcSolidsEnergy(first_of_effects, problem.solids.size(), 0);
  double energy_mJ = drawn_mJ + edge.SetDepths(problem, true) + faces.SetDepths(problem, true);
  if (energy_mJ - contact_mJ > reserve_mJ) {
    double held_mJ = edge.SetDepths(problem, false) + faces.SetDepths(problem, false);
    // Springs that have become stiffer in a transition between two fidelities are deflected less.
    const double max_mJ = std::max(0.0, contact_mJ + reserve_mJ - drawn_mJ);
    if (held_mJ > max_mJ) {
      edge.Ease(std::sqrt(max_mJ / held_mJ));
      faces.Ease(std::sqrt(max_mJ / held_mJ));
      held_mJ = edge.SetDepths(problem, false) + faces.SetDepths(problem, false);
    }
    energy_mJ = drawn_mJ + held_mJ;
  }
  Reserve(contact_mJ - energy_mJ);
  contact_mJ = energy_mJ;
}

/// Returns the fraction of a motion that the tool may make before contact is found again, 0 to 1.
double CoupledSimulation::State::CalcStepFraction(const Twist& motion, double time_s) const {
  const Vec3 w(motion[3], motion[4], motion[5]);
  const Vec3 v = Vec3(motion[0], motion[1], motion[2]) - glm::cross(w, coupling.p_TC_mm());  // of the tool's origin
  // Rotation about a distant coupling point moves the tool on an arc, which deviates from the straight line by this
  // much.
  const double bent = 0.5 * glm::length(w) * glm::length(glm::cross(w, coupling.p_TC_mm())) * time_s * time_s;
  double steps = glm::length(w) * time_s / kLargestTurn_rad;
  if (is_blade) {
    double across = std::hypot(v.x, v.y) * time_s;
    if (drive.strokes()) across += std::abs(w.z) * shape.reach_mm * time_s;  // such a blade is not round
    const double along = (std::abs(v.z) + std::hypot(w.x, w.y) * shape.reach_mm) * time_s;
    steps = std::max({steps, CountSteps(across, bent, kStepVoxels * h),
                      CountSteps(along, bent, kAxialFraction * std::min(h, CalcThickness(params.tool)))});
  } else {
    // The rotation of a ball changes nothing.
    const double turned = is_round ? std::hypot(w.x, w.y) * shape.reach_mm * time_s : 0;
    steps = std::max(steps, CountSteps(glm::length(v) * time_s + turned, bent, kStepVoxels * h));
    if (is_round) steps = std::max(steps, CountSteps(turned, bent, kAxialFraction * h));
  }
  for (const StepProblem::MotionLimit& limit : problem.limits) {
    if (!(limit.reach_mm > 0)) continue;
    const double at_reach = glm::length(Vec3(motion[0], motion[1], motion[2])) + glm::length(w) * limit.reach_mm;
    steps = std::max(steps, at_reach * time_s / limit.largest_mm);
  }
  return steps > 1 ? 1 / steps : 1;
}

/// Moves the tool towards the handle for in.dt_s, in as many substeps as needed. Returns false if the tool lags
/// behind because the substeps or the leaves are used up.
bool CoupledSimulation::State::Follow(const CoupledInput& in, int max_substeps, TickObserver* observer, Sums& sums,
                                      CoupledOutput& out) {
  const auto enter = [observer](TickStage stage) {
    if (observer) observer->Enter(stage);
  };
  bool reached = false;
  double left_s = in.dt_s;
  while (!reached) {
    if (out.substeps == max_substeps) {
      out.status |= kCoupledSubstepsUsedUp;
      return false;
    }
    // 2 near: through air the tool moves with the handle
    enter(TickStage::kNear);
    const Flight flight = Fly(in, out);
    if (flight == Flight::kArrived) {
      if (out.substeps == 0) out.status |= kCoupledAsleep;
      sums.f_damper_W = sums.tau_damper_W = Vec3(0);
      return true;
    }
    ++out.substeps;
    if (flight == Flight::kUnderWay) continue;

    // 3 engage: the bone in contact with the tool at its pose
    enter(TickStage::kEngage);
    if (drive.strokes()) Stroke(in, left_s);
    Engage(in, left_s, observer);

    const double before_mJ = CalcBalance(out);
    // 4 solve: the motion at which coupling and bone are in balance
    enter(TickStage::kSolve);
    const bool free = problem.empty();
    if (free) {
      const Vec3 v = problem.coupling.x_mm / left_s;
      const Vec3 w = problem.coupling.theta_rad / left_s;
      Release();
      u = {v.x, v.y, v.z, w.x, w.y, w.z};
    } else {
      const StepSolution solution = solver.Solve(problem, u, shape.reach_mm, params.max_iterations);
      if (has_own_law) CheckSolution(problem, solution, u, params.law.name());
      u = solution.u;
      out.iterations = std::max(out.iterations, solution.iterations);
      if (!solution.converged) out.status |= kCoupledIterationsUsedUp;
    }
    const double fraction = CalcStepFraction(u, left_s);
    const double time_s = fraction * left_s;
    reached = fraction == 1;
    const Pose X_next = free && reached ? in.X_WH : Advance(X_WT, u, time_s, coupling.p_TC_mm());
    const Pose X_from = X_WT;

    // 5 remove: the sweep of the edge
    enter(TickStage::kRemove);
    if (in.rpm == 0) {
      CutWaiting(out);
    } else if (bone_fraction == 0) {
      CutWaiting(out);
      path.Record(X_WT, kStepVoxels * h);
    } else {
      SlideRange slide;
      if (drive.strokes()) {
        slide = drive.CalcStep(phase_rad, in.rpm, time_s, tick_s).range;
        phase_rad = Drive::Advance(phase_rad, in.rpm, time_s);
      }
      const Cutter::Result cut = paced.Cut(X_WT, X_next, slide);
      out.removed_mm3 += cut.removed_mm3;
      if (cut.out_of_leaves) {
        out.status |= kCoupledLeavesUsedUp;
        u = {};
        return false;
      }
    }
    AddUp(time_s, sums, out);
    if (const double sum_N = sums.teeth.thrust_N + sums.teeth.cutting_N; !(sum_N >= 0 && std::isfinite(sum_N))) {
      ThrowBadSum(problem, u, sum_N, params.law.name());
    }
    Move(X_next, fraction);
    if (!free && effects.wants_solved()) {
      const EffectsStage stage(observer, effects, TickStage::kRemove);
      EffectSolved solved{X_from, X_WT, edge, &faces, problem, u, fraction, time_s, in.rpm, {}, StrokeOrNull()};
      effects.Solved(solved);
    }
    if (!free) Reserve(before_mJ - CalcBalance(out));
    left_s -= time_s;
  }
  return true;
}

}  // namespace kerf
