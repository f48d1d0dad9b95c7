#include "kerf/coupled.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cut/contact/broken_rule.h"
#include "cut/hand_sim/internals.h"
#include "cut/hand_sim/state.h"
#include "kerf/simulation.h"

namespace kerf {
namespace {

constexpr double kFlatStiffness_N_per_mm = 3000;   // of each point of a flat
constexpr double kSolidStiffness_N_per_mm = 2000;  // for a stopped edge: see CalcSolidStiffness()
constexpr double kStepVoxels = 0.5;                // maximum motion of the tool in a substep, in voxels
constexpr double kAxialFraction = 0.25;            // along the spindle, in voxels or thicknesses of a thinner disc
constexpr double kLargestTurn_rad = 0.5;
constexpr double kMarginVoxels = 1.5;  // bone within this distance is near
constexpr double kMaxTick_s = 1;
constexpr double kMaxSpeed = 1e6;  // of the handle, mm/s and rad/s

bool IsFinite(const Vec3& v, double limit) {
  return std::abs(v.x) <= limit && std::abs(v.y) <= limit && std::abs(v.z) <= limit;
}

/// Returns the number of parts into which a motion must be divided so that each is at most `max_length` long. The
/// straight part of a motion is inversely proportional to the number of parts, and the bend is inversely proportional
/// to the square of that number.
double CountSteps(double straight, double bent, double max_length) {
  return (straight + std::sqrt(straight * straight + 4 * bent * max_length)) / (2 * max_length);
}

/// Returns the stiffness of each point of a stopped edge, N/mm. The stiffness of an eighth of a disc's pitch, or of one
/// part in 512 of a ball, does not depend on the number of points.
double CalcSolidStiffness(const ToolShape& shape) {
  const double parts = shape.edge_is_ring ? std::max(64.0, 8 * shape.passes_per_turn) : 512;
  return kSolidStiffness_N_per_mm * parts / static_cast<double>(shape.edge.size());
}

}  // namespace

CoupledSimulation CoupledInternals::Make(Bone bone, const ComparedParams& params, const Pose& X_WT_start) {
  CheckParams(params);
  CheckRange("precision_bits", params.precision_bits, kPrecisionRange_bits);
  CheckTissues(params.law, bone);
  CoupledSimulation simulation;
  simulation.state_ = std::make_unique<CoupledSimulation::State>(std::move(bone), params, MakeStart(X_WT_start));
  return simulation;
}

CoupledSimulation::CoupledSimulation() noexcept = default;
CoupledSimulation::CoupledSimulation(Bone bone, const CoupledParams& params, const Pose& X_WT_start)
    : CoupledSimulation(CoupledInternals::Make(std::move(bone), {params}, X_WT_start)) {}
CoupledSimulation::~CoupledSimulation() = default;
CoupledSimulation::CoupledSimulation(CoupledSimulation&&) noexcept = default;
CoupledSimulation& CoupledSimulation::operator=(CoupledSimulation&&) noexcept = default;

bool CoupledSimulation::State::Accepts(const CoupledInput& in) const {
  return IsValid(in.X_WH) && IsInWorld(in.X_WH.p_AB) && IsFinite(in.v_H_W_mm_per_s, kMaxSpeed) &&
         IsFinite(in.w_H_W_rad_per_s, kMaxSpeed) && in.dt_s >= 0 && in.dt_s <= kMaxTick_s &&
         std::abs(in.rpm) <= kMaxRpm;
}

/// Returns the last tick's output, for a tick in which nothing happens.
CoupledOutput CoupledSimulation::State::Repeat() const {
  CoupledOutput out = last;
  out.regions_cut = {};
  out.removed_mm3 = 0;
  out.hand_mJ = out.spindle_mJ = 0;
  out.stored_mJ = out.cut_mJ = out.friction_mJ = out.damping_mJ = out.numerical_mJ = 0;
  out.substeps = out.iterations = 0;
  out.status = kCoupledNoTime;
  return out;
}

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

/// Sets up the problem of a step at the tool's pose.
void CoupledSimulation::State::Engage(const CoupledInput& in, double time_s, TickObserver* observer) {
  const Probe probe(field, X_WT);
  problem.Clear();
  problem.tau_s = time_s;
  problem.coupling = coupling.MakeStep(X_WT, in);
  const bool turning = in.rpm != 0;
  const double axial_mm = kAxialFraction * std::min(h, CalcThickness(params.tool));
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
    if (field.has_metal()) {
      edge.FindMetal(probe, (kStepVoxels + kAxialFraction) * h, bone_fraction * CalcSolidStiffness(shape), problem);
    }
  } else {
    edge.FindSolids(probe, (kStepVoxels + kAxialFraction) * h, bone_fraction * CalcSolidStiffness(shape), problem);
  }
  if (is_disc && reads_bone) {
    faces.Find(probe, axial_mm, turning, problem);
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
    effects.Engage({X_WT, probe, edge, &faces, in.rpm, reads_bone}, problem);
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
  if (is_disc) {
    const double across = std::hypot(v.x, v.y) * time_s;
    const double along = (std::abs(v.z) + std::hypot(w.x, w.y) * shape.reach_mm) * time_s;
    steps = std::max({steps, CountSteps(across, bent, kStepVoxels * h),
                      CountSteps(along, bent, kAxialFraction * std::min(h, CalcThickness(params.tool)))});
  } else {
    steps = std::max(steps, CountSteps(glm::length(v) * time_s, bent, kStepVoxels * h));
  }
  return steps > 1 ? 1 / steps : 1;
}

/// Adds the forces, the energies and the material in contact, for a substep with motion `u` over `time_s`.
void CoupledSimulation::State::AddUp(double time_s, Sums& sums, CoupledOutput& out) {
  sums.f_damper_W = sums.tau_damper_W = Vec3(0);
  sums.time_s += time_s;
  if (problem.empty()) return;
  sums.touched = true;
  double teeth_now = 0;
  Vec3 f_edge_T(0);
  Vec3 f_face_T(0);
  Vec3 f_friction_T(0);
  for (std::size_t i = 0; i < problem.cutting.size(); ++i) {
    const CuttingPoint& p = problem.cutting[i];
    const double speed = Dot(p.row, u);
    sums.teeth.teeth += time_s * p.teeth;
    teeth_now += p.teeth;
    sums.teeth.E_MPa += time_s * p.teeth * p.cut.E_MPa;
    const double along = problem.arc_rad > 0 ? Dot(p.along, u) : 0;
    const ToothMean mean = problem.MeanToothForce(p, speed, along);
    if (!(speed > 0) && !(mean.radial_N > 0)) continue;
    const double force = p.teeth * mean.radial_N;
    f_edge_T -= force * Vec3(p.row[0], p.row[1], p.row[2]);
    double magnitude = force, work_mJ = time_s * force * speed;
    if (mean.along_N != 0) {
      magnitude = p.teeth * std::hypot(mean.radial_N, mean.along_N);
      f_edge_T -= p.teeth * mean.along_N * Vec3(p.along[0], p.along[1], p.along[2]);
      work_mJ += time_s * p.teeth * mean.along_N * along;
    }
    sums.teeth.thrust_N += time_s * magnitude;
    if (problem.law.HasCutting()) {
      const double cutting = p.teeth * problem.MeanCuttingForce(p, speed, mean);
      sums.teeth.AddCutting(cutting, time_s, p.cut.speed_mm_per_s);
    }
    const auto region = static_cast<std::size_t>(edge.contacts()[i].region);
    sums.teeth.thrust_by_region_N[region] += time_s * magnitude;
    out.regions_cut[region / 64] |= std::uint64_t{1} << (region % 64);
    sums.teeth.bite_mm += time_s * p.teeth * std::max(speed, 0.0) / problem.passes_per_s;
    out.cut_mJ += std::max(0.0, work_mJ);  // < 0 only by rounding: the potential is convex and minimal at rest
  }
  for (const FlatPoint& p : problem.flats) {
    const double speed = p.side * (u[2] + u[3] * p.y - u[4] * p.x);
    const double force = problem.flat_stiffness_N_per_mm * std::max(0.0, p.depth_mm + problem.tau_s * speed);
    f_face_T.z -= force * p.side;
    sums.given_mJ -= time_s * force * speed;
  }
  for (std::size_t i = 0; i < problem.solids.size(); ++i) {
    const SolidPoint& p = problem.solids[i];
    const double speed = Dot(p.row, u);
    const double force = p.stiffness_N_per_mm * std::max(0.0, p.depth_mm + problem.tau_s * speed);
    if (i < first_of_effects) f_face_T -= force * Vec3(p.row[0], p.row[1], p.row[2]);
    if (i < edge.found_count() && force > 0 && (out.status & kCoupledSpindleStopped) == 0) {
      out.status |= kCoupledTouchesMetal;
    }
    sums.given_mJ -= time_s * force * speed;
  }
  const double creep2 = problem.creep_mm_per_s * problem.creep_mm_per_s;
  for (const FrictionPoint& p : problem.frictions) {
    const double own_a = Dot(p.row_a, u);
    const double own_b = Dot(p.row_b, u);
    const double a = own_a + p.slip_a_mm_per_s;
    const double b = own_b + p.slip_b_mm_per_s;
    const double factor = p.limit_N / std::sqrt(a * a + b * b + creep2);
    f_friction_T -=
        factor * (a * Vec3(p.row_a[0], p.row_a[1], p.row_a[2]) + b * Vec3(p.row_b[0], p.row_b[1], p.row_b[2]));
    // If friction drives the tool, the spindle does the work.
    const double power = factor * (a * own_a + b * own_b);
    (power >= 0 ? out.friction_mJ : out.spindle_mJ) += time_s * std::abs(power);
  }
  if (bone_fraction == 1) {
    f_cut_T = f_edge_T;
    teeth = teeth_now;
  }
  for (const YieldPoint& p : problem.yields) {
    const double speed = Dot(p.row, u);
    if (!(speed > 0)) continue;
    const double force = p.Force(speed, problem.creep_mm_per_s);
    f_edge_T -= force * Vec3(p.row[0], p.row[1], p.row[2]);
    sums.teeth.thrust_N += time_s * force;
    out.cut_mJ += time_s * force * speed;
  }
  sums.f_cut_W += time_s * X_WT.Vector(f_edge_T);
  sums.f_face_W += time_s * X_WT.Vector(f_face_T);
  sums.f_friction_W += time_s * X_WT.Vector(f_friction_T);
  const StepCoupling& c = problem.coupling;
  const Vec3 v(u[0], u[1], u[2]);
  const Vec3 w(u[3], u[4], u[5]);
  sums.given_mJ += time_s * (glm::dot(c.spring.Force(c.x_mm - problem.tau_s * v), v) +
                             glm::dot(c.torsion.Force(c.theta_rad - problem.tau_s * w), w));
  const Vec3 slip = c.v_H_mm_per_s - v;
  const Vec3 turn = c.w_H_rad_per_s - w;
  const Vec3 f = c.damper.Force(slip);
  const Vec3 tau = c.torsion_damper.Force(turn);
  out.hand_mJ += time_s * (glm::dot(f, c.v_H_mm_per_s) + glm::dot(tau, c.w_H_rad_per_s));
  out.damping_mJ += time_s * (glm::dot(f, slip) + glm::dot(tau, turn));
  sums.f_damper_W = -X_WT.Vector(f);
  sums.tau_damper_W = -X_WT.Vector(tau);
}

/// Sets the output: means over the completed time, and the load on the hand.
void CoupledSimulation::State::Publish(const Sums& sums, CoupledOutput& out) const {
  out.X_WT = World(X_WT);
  const Coupling::Load load = coupling.CalcLoadOnHand(X_WT, X_WH);
  out.f_H_W_N = load.f_W_N + sums.f_damper_W;
  out.tau_H_W_Nmm = load.tau_W_Nmm + sums.tau_damper_W;
  if (load.limited) out.status |= kCoupledForceLimited;
  if (sums.time_s > 0) {
    out.f_cut_W_N = sums.f_cut_W / sums.time_s;
    out.f_face_W_N = sums.f_face_W / sums.time_s;
    out.f_friction_W_N = sums.f_friction_W / sums.time_s;
    sums.teeth.Report(sums.time_s, out);
  }
}

/// Removes all bone inside the tool in the first tick with a turning spindle. The flats do not cut afterwards, so bone
/// in contact with them would hold the tool.
void CoupledSimulation::State::CutAtStart(CoupledOutput& out) {
  if (!at_start) return;
  const Cutter::Result cut = cutter.CutAround(X_WT);
  out.removed_mm3 += cut.removed_mm3;
  if (cut.out_of_leaves) out.status |= kCoupledLeavesUsedUp;
  at_start = cut.out_of_leaves;
}

/// Moves the handle while the tool is held; the tool follows afterwards.
void CoupledSimulation::State::MoveHandle(const Pose& X_to, Sums& sums, CoupledOutput& out) {
  const double drawn_mJ = coupling.CalcEnergy(X_WT, X_to) - coupling_mJ;
  coupling_mJ += drawn_mJ;
  out.hand_mJ += drawn_mJ;
  sums.drawn_mJ += drawn_mJ;
  X_WH = X_to;
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
      const Cutter::Result cut = paced.Cut(X_WT, X_next);
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
      EffectSolved solved{X_from, X_WT, edge, &faces, problem, u, fraction, time_s, in.rpm, {}};
      effects.Solved(solved);
    }
    if (!free) Reserve(before_mJ - CalcBalance(out));
    left_s -= time_s;
  }
  return true;
}

CoupledOutput CoupledSimulation::Tick(const CoupledInput& input, TickObserver* observer) {
  State& s = *state_;
  ++s.ticks;
  const Pose X_WT_before = s.X_WT, X_WH_before = s.X_WH;
  const PacedCutter paced_before = s.paced;
  const bool at_start_before = s.at_start;
  try {
    return CallOwn("force law", s.params.law.name(), [&] { return s.Tick(input, observer); });
  } catch (BrokenRule& fault) {
    s.X_WT = X_WT_before;
    s.X_WH = X_WH_before;
    s.paced = paced_before;
    s.at_start = at_start_before;
    SetDown(s.World(X_WT_before));
    fault.SetTick(s.ticks);
    throw;
  }
}

CoupledOutput CoupledSimulation::State::Tick(const CoupledInput& input, TickObserver* observer) {
  State& s = *this;
  CoupledInput in = input;
  if (std::abs(in.rpm) < kMinRpm) in.rpm = 0;
  CoupledOutput out;
  const auto enter = [observer](TickStage stage) {
    if (observer) observer->Enter(stage);
  };

  // 1 accept: reject invalid input
  enter(TickStage::kAccept);
  if (!s.Accepts(in)) {
    out.X_WT = s.last.X_WT;
    out.status = kCoupledBadPose;
    s.last = out;
    enter(TickStage::kEnd);
    return out;
  }
  if (in.dt_s < kMinTick_s) {
    enter(TickStage::kEnd);
    return s.Repeat();
  }
  in.X_WH = s.Local(in.X_WH);
  EffectBegin begin{in.dt_s, input.rpm, in.rpm};
  {
    const EffectsStage stage(observer, s.effects, TickStage::kAccept);
    s.effects.Begin(begin);
  }
  in.rpm = begin.rpm;
  if (in.rpm == 0) out.status |= kCoupledSpindleStopped;
  const double stored_mJ = s.coupling_mJ + s.contact_mJ;
  const Pose X_from = s.X_WH;
  s.StepFidelity(in, out);
  if (in.rpm != 0) s.CutAtStart(out);
  s.problem.passes_per_s = s.shape.passes_per_turn * std::abs(in.rpm) / 60;

  State::Sums sums;
  const int max_substeps =
      (s.fidelity == Fidelity::kFull ? s.params.max_substeps : std::max(1, s.params.max_substeps / 4)) +
      s.params.substeps - 1;
  s.paced.BeginTick();
  bool reached = true;
  CoupledInput part = in;
  part.dt_s = in.dt_s / s.params.substeps;
  for (int i = 1; i <= s.params.substeps && reached; ++i) {
    if (i < s.params.substeps) {
      part.X_WH = Interpolate(X_from, in.X_WH, static_cast<double>(i) / s.params.substeps);
    } else {
      part.X_WH = in.X_WH;
    }
    s.MoveHandle(part.X_WH, sums, out);
    reached = s.Follow(part, max_substeps, observer, sums, out);
  }
  if (!reached) s.MoveHandle(in.X_WH, sums, out);

  // 6 effects of the whole tick
  const double mean = sums.time_s > 0 ? 1 / sums.time_s : 0;
  EffectEnd end{in.dt_s,
                input.rpm,
                in.rpm,
                s.X_WT,
                (out.status & kCoupledAsleep) != 0,
                mean * sums.teeth.teeth,
                mean * sums.teeth.thrust_N,
                out.removed_mm3};
  {
    const EffectsStage stage(observer, s.effects, TickStage::kPublish);
    s.effects.End(end);
  }

  // 7 publish
  enter(TickStage::kPublish);
  s.Publish(sums, out);
  if (end.f_extra_W_N != Vec3(0)) out.f_H_W_N += end.f_extra_W_N;
  // If tool and handle coincide, the output is the input's pose, without the rounding of the frame change.
  if (s.X_WT.p_AB == in.X_WH.p_AB && s.X_WT.R_AB == in.X_WH.R_AB) out.X_WT = input.X_WH;
  if (!sums.touched && reached) out.hand_mJ = sums.drawn_mJ = 0;  // in air handle and tool move as one
  out.stored_mJ = s.coupling_mJ + s.contact_mJ - stored_mJ;
  // Only springs lose energy to the finite step: all other terms are the work of forces at its end.
  out.numerical_mJ = sums.drawn_mJ - sums.given_mJ - out.stored_mJ;
  s.last = out;
  enter(TickStage::kEnd);
  return out;
}

bool CoupledSimulation::SetDown(const Pose& X_WT) {
  if (!IsValid(X_WT) || !IsInWorld(X_WT.p_AB)) return false;
  State& s = *state_;
  CoupledOutput unused;
  s.CutWaiting(unused);
  s.X_WT = s.Local(X_WT);
  s.last = {};
  s.last.X_WT = X_WT;
  s.u = {};
  s.edge.Forget();
  s.faces.Forget();
  s.effects.Reset();
  s.contact_mJ = s.guide_mJ = s.effects_mJ = s.reserve_mJ = 0;
  s.EndSlab();
  s.path.Forget();
  s.teeth = 0;
  s.paced.Forget();
  s.cutter.Lift();
  s.coupling_mJ = s.coupling.CalcEnergy(s.X_WT, s.X_WH);
  return true;
}

void CoupledSimulation::Refill() {
  state_->field.Refill(state_->params.spare_leaves);
  state_->cutter.Refill();
}

int CoupledSimulation::changed_count() const {
  return static_cast<int>(state_->field.changed().size());
}
ChangedLeaf CoupledSimulation::changed(int i) const {
  return state_->field.ReadChanged(i);
}
void CoupledSimulation::ClearChanged() {
  state_->field.ClearChanged();
}

const CoupledParams& CoupledSimulation::params() const {
  return state_->params;
}
std::vector<std::string> CoupledSimulation::ListChannels() const {
  return state_->effects.ListChannels();
}

void CoupledSimulation::ReadChannels(std::span<double> values) const {
  state_->effects.Report(values);
}

EffectPlan& CoupledInternals::Effects(const CoupledSimulation& simulation) {
  return simulation.state_->effects;
}
std::array<double, 256> CoupledSimulation::CalcRemovedByRegion() {
  state_->FinishPath();
  std::array<double, 256> mm3 = state_->cutter.CalcRemovedByRegion();
  for (std::size_t id = 0; id < mm3.size(); ++id) mm3[id] -= state_->taken_out_mm3[id];
  return mm3;
}
const Bone& CoupledSimulation::UpdateBone() {
  state_->FinishPath();
  state_->field.Settle();
  return state_->bone;
}
Bone CoupledSimulation::TakeBone() && {
  state_->FinishPath();
  state_->field.Settle();
  return std::move(state_->bone);
}
std::size_t CoupledSimulation::CalcMemoryBytes() const {
  return state_->field.CalcMemoryBytes() + state_->cutter.CalcMemoryBytes() + state_->clearance.CalcMemoryBytes() +
         state_->effects.CalcMemoryBytes() + (state_->history ? state_->history->CalcMemoryBytes() : 0) + sizeof(State);
}

}  // namespace kerf
