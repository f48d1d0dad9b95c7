#include "kerf/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "bone/grid/piece_removal.h"
#include "cut/contact/broken_rule.h"
#include "cut/contact/edge.h"
#include "cut/contact/motion.h"
#include "cut/effects/plan.h"
#include "cut/effects/spindle/spindle.h"
#include "cut/path_sim/internals.h"
#include "cut/path_sim/teeth_sums.h"
#include "cut/removal/paced_cutter.h"
#include "cut/tool/drive.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kMaxSubsteps = 4096;
constexpr int kSpareLeaves = 4096;
constexpr double kNoFaces_mm = 1e3;  // large spacing: a tool on a path does not use the points of its flats

/// Load on the tool in its frame's axes, about the tool's origin.
struct EdgeLoad {
  Vec3 f_T_N{0};
  Vec3 tau_T_Nmm{0};
  TeethSums sums;  // of the teeth that move outwards
};

}  // namespace

struct Simulation::State {
  State(Bone the_bone, const SimulationParams& the_params, const Pose& X_WT_start)
      : bone(std::move(the_bone)),
        params(the_params),
        drive(params.tool),
        shape(MakeToolShape(params.tool, {params.rim_samples_per_pitch, kNoFaces_mm, 0, 0})),
        field(bone, kSpareLeaves),
        edge(field, bone, params.tool, shape, Vec3(0)),
        problem(MakeStepProblem(MakeToothForce(params.law, params.tool))),
        cutter(field, params.tool, CutWith::kWholeTool),
        paced(cutter, params.tool, shape.reach_mm, field.voxel_mm(), params.carve_interval_ticks),
        effects(params.effects,
                {bone, field, params.tool, shape, edge, problem.law, nullptr, Vec3(0), field.p_WF_mm()}),
        spindle(static_cast<const SpindleEffect*>(effects.Find("spindle"))),
        X_WT(Local(X_WT_start)) {
    problem.cutting.reserve(shape.edge.size());
    problem.solids.reserve(effects.capacity().solids);
    problem.frictions.reserve(effects.capacity().frictions);
    angle_between_points = std::max(glm::length(shape.edge[1].e_T - shape.edge[0].e_T), 1e-12);
    constexpr double kRounding = 1e-9;
    has_levers = std::ranges::any_of(shape.edge, [&](const EdgePoint& point) {
      return glm::length(glm::cross(point.p_T, point.e_T)) > kRounding * shape.reach_mm;
    });
  }

  /// Within a tick all poses are in the field's frame F, which replaces W.
  Pose Local(const Pose& X) const { return WithUnitRotation({X.R_AB, X.p_AB - field.p_WF_mm()}); }
  TickOutput Repeat() const;
  void Refill() { field.Refill(kSpareLeaves); }
  void CutRest(const Pose& X_to);
  Twist CalcTwist(const Pose& X_a, const Pose& X_b, double dt_s) const;
  // Not inlined, so that its loop compiles to the same code regardless of the rest of the tick (tools/off_is_free).
  [[gnu::noinline]] EdgeLoad CalcLoad(const Pose& X, const Twist& u, double passes_per_s);
  void AddEffects(const Pose& X_a, const Pose& X_b, const Twist& u, double rpm, double dt_s, const DriveStep* stroke,
                  EdgeLoad& load);
  TickOutput Tick(const TickInput& in, TickObserver* observer);

  Bone bone;
  SimulationParams params;
  Drive drive;
  double phase_rad = 0;  // of a stroke
  StrokeBites bites;     // of its substep
  ToolShape shape;
  BoneField field;
  Edge edge;
  StepProblem problem;          // points in contact with bone
  double angle_between_points;  // between the directions of neighbours on the edge, rad; above 0
  bool has_levers;              // not all of the teeth's forces point to the origin: a rotation moves teeth outwards
  Cutter cutter;
  PacedCutter paced;
  EffectPlan effects;
  const SpindleEffect* spindle;  // null: without a motor
  Pose X_WT;                     // last valid pose
  TickOutput last;               // output of the last tick
  std::uint64_t ticks = 0;
  std::array<double, 256> taken_out_mm3{};
};

/// Returns the last tick's output, for a tick in which nothing happens.
TickOutput Simulation::State::Repeat() const {
  TickOutput out = last;
  out.removed_mm3 = 0;
  out.status = kTickNoTime;
  return out;
}

/// Removes all pending bone, up to the tool's pose. May allocate.
void Simulation::State::CutRest(const Pose& X_to) {
  while (paced.Flush(X_to).out_of_leaves) Refill();
}

/// Returns the velocity of the tool from X_a to X_b, in the frame of X_a. Left out are the rotations that move no tooth
/// outwards: those of a tool whose teeth all face away from its origin, and that of a bur or drill about its axis.
/// Tick-safe.
Twist Simulation::State::CalcTwist(const Pose& X_a, const Pose& X_b, double dt_s) const {
  const Vec3 v = X_a.InverseVector(X_b.p_AB - X_a.p_AB) / dt_s;
  if (!has_levers) return {v.x, v.y, v.z, 0, 0, 0};
  const Vec3 w = CalcAngularVelocity(X_a.R_AB, X_b.R_AB, dt_s);
  return {v.x, v.y, v.z, w.x, w.y, shape.edge_form == EdgeForm::kChain ? w.z : 0};
}

/// Returns the mean load over many tooth passages while the tool moves with the twist `u` about its origin. Error:
/// docs/physics.md. Tick-safe.
EdgeLoad Simulation::State::CalcLoad(const Pose& X, const Twist& u, double passes_per_s) {
  problem.passes_per_s = passes_per_s;
  edge.FindTeeth(Probe(field, X), problem);
  EdgeLoad load;
  const Vec3 v_T_mm_per_s(u[0], u[1], u[2]);
  const Vec3 w_T_rad_per_s(u[3], u[4], u[5]);
  const bool rotates = w_T_rad_per_s != Vec3(0);
  const auto feed_of = [&](const Vec3& v) {
    return glm::length(v - Vec3(0, 0, shape.edge_form != EdgeForm::kSurface ? v.z : 0));
  };
  double feed = feed_of(v_T_mm_per_s);
  if (!(feed > 0) && !rotates) return load;
  double inv_change = 1 / (feed * angle_between_points);
  for (std::size_t i = 0; i < problem.cutting.size(); ++i) {
    const CuttingPoint& point = problem.cutting[i];
    const double outwards = Dot(point.row, u);
    if (rotates) {
      feed = feed_of(v_T_mm_per_s + glm::cross(w_T_rad_per_s, edge.Lever(edge.contacts()[i])));
      if (!(feed > 0)) continue;
      inv_change = 1 / (feed * angle_between_points);
    }
    const double along = glm::dot(Vec3(point.along[0], point.along[1], point.along[2]), v_T_mm_per_s);
    const double speed = std::max(0.0, outwards);
    // If the outward half of the edge ends within the arc of the point, only a part of that arc counts.
    const double outward = std::clamp(0.5 + outwards * inv_change, 0.0, 1.0);
    const double teeth = outward * point.teeth;
    const ToothMean mean = problem.MeanToothForce(point, outwards, along);
    const double force = point.teeth * mean.radial_N;
    load.f_T_N -= force * point.FindOutwards(outwards, along);
    if (has_levers) load.tau_T_Nmm -= force * Vec3(point.row[3], point.row[4], point.row[5]);
    load.sums.thrust_N += force;
    load.sums.AddThrustPower(point.teeth * problem.MeanThrustOnWay(point, outwards, mean), 1, point.cut.speed_mm_per_s);
    if (problem.law.HasCutting()) {
      const double cutting = point.teeth * problem.MeanCuttingForce(point, outwards, mean);
      load.sums.AddCutting(cutting, 1, point.cut.speed_mm_per_s);
    }
    load.sums.thrust_by_region_N[static_cast<std::size_t>(edge.contacts()[i].region)] += force;
    load.sums.teeth += teeth;
    load.sums.E_MPa += teeth * point.cut.E_MPa;
    load.sums.bite_mm += teeth * speed / passes_per_s;
  }
  return load;
}

/// Adds the load of the effects for the tool's motion, and passes the motion on to them. Tick-safe.
void Simulation::State::AddEffects(const Pose& X_a, const Pose& X_b, const Twist& u, double rpm, double dt_s,
                                   const DriveStep* stroke, EdgeLoad& load) {
  problem.tau_s = dt_s;
  problem.solids.clear();
  problem.frictions.clear();
  const std::span<ToothLoad> teeth = stroke != nullptr ? effects.FindTeeth(problem, edge, u) : std::span<ToothLoad>();
  effects.Engage({X_a, Probe(field, X_a), edge, nullptr, rpm, true, stroke, teeth}, problem);
  Twist sum{};
  for (const SolidPoint& p : problem.solids) {
    AddTo(sum, -p.stiffness_N_per_mm * std::max(0.0, p.depth_mm + dt_s * Dot(p.row, u)), p.row);
  }
  for (const FrictionPoint& p : problem.frictions) {
    const double a = Dot(p.row_a, u) + p.slip_a_mm_per_s;
    const double b = Dot(p.row_b, u) + p.slip_b_mm_per_s;
    const double factor = p.limit_N / std::sqrt(a * a + b * b + problem.creep_mm_per_s * problem.creep_mm_per_s);
    AddTo(sum, -factor * a, p.row_a);
    AddTo(sum, -factor * b, p.row_b);
  }
  load.f_T_N += Vec3(sum[0], sum[1], sum[2]);
  load.tau_T_Nmm += Vec3(sum[3], sum[4], sum[5]);
  if (!effects.wants_solved()) return;
  EffectSolved solved{X_a, X_b, edge, nullptr, problem, u, 1, dt_s, rpm, {}, stroke};
  effects.Solved(solved);
}

Simulation::Simulation(Bone bone, const SimulationParams& params, const Pose& X_WT_start) {
  Validate(params.tool);
  CheckParameters(params);
  CheckTissues(params.law, bone);
  if (!IsValid(X_WT_start)) throw Error("the tool's start pose is not finite or its quaternion is not of unit length");
  if (!IsInWorld(X_WT_start.p_AB)) {
    throw Error(fmt::format("the tool's start position is more than {} mm from the world origin", kWorldReach_mm));
  }
  state_ = std::make_unique<State>(std::move(bone), params, X_WT_start);
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

std::vector<std::string> Simulation::ListChannels() const {
  return state_->effects.ListChannels();
}

void Simulation::ReadChannels(std::span<double> values) const {
  state_->effects.Report(values);
}

EffectPlan& SimulationInternals::Effects(const Simulation& simulation) {
  return simulation.state_->effects;
}
const Bone& Simulation::UpdateBone() {
  state_->CutRest(state_->X_WT);
  state_->field.Settle();
  return state_->bone;
}
Bone Simulation::TakeBone() && {
  state_->CutRest(state_->X_WT);
  state_->field.Settle();
  return std::move(state_->bone);
}
std::array<double, 256> Simulation::CalcRemovedByRegion() {
  state_->CutRest(state_->X_WT);
  std::array<double, 256> mm3 = state_->cutter.CalcRemovedByRegion();
  for (std::size_t id = 0; id < mm3.size(); ++id) mm3[id] -= state_->taken_out_mm3[id];
  return mm3;
}
bool Simulation::IsClearOf(const Box3& bounds_W) const {
  const State& s = *state_;
  return IsToolClearOf(bounds_W, s.X_WT.p_AB + s.field.p_WF_mm(), s.shape.reach_mm, s.field.voxel_mm());
}
bool Simulation::Replace(const std::array<int, 3>& index, const float* from, const float* to) {
  return state_->cutter.Replace(state_->field.FromWorld(index), from, to);
}
void Simulation::AddTakenOut(const std::array<double, 256>& mm3, double sign) {
  for (std::size_t id = 0; id < mm3.size(); ++id) state_->taken_out_mm3[id] += sign * mm3[id];
}
void Simulation::Refill() {
  state_->Refill();
}

int Simulation::changed_count() const {
  return static_cast<int>(state_->field.changed().size());
}
ChangedLeaf Simulation::changed(int i) const {
  return state_->field.ReadChanged(i);
}
void Simulation::ClearChanged() {
  state_->field.ClearChanged();
}

bool Simulation::SetDown(const Pose& X_WT) {
  if (!IsValid(X_WT) || !IsInWorld(X_WT.p_AB)) return false;
  state_->CutRest(state_->X_WT);
  state_->X_WT = state_->Local(X_WT);
  state_->last = {};
  state_->effects.Reset();
  state_->cutter.Lift();
  return true;
}

TickOutput Simulation::Tick(const TickInput& in, TickObserver* observer) {
  State& s = *state_;
  ++s.ticks;
  const Pose X_before = s.X_WT;
  const double phase_before = s.phase_rad;
  const PacedCutter paced_before = s.paced;
  try {
    return s.Tick(in, observer);
  } catch (BrokenRule& fault) {
    s.X_WT = X_before;
    s.phase_rad = phase_before;
    s.paced = paced_before;
    s.cutter.Lift();
    fault.SetTick(s.ticks);
    throw;
  }
}

TickOutput Simulation::State::Tick(const TickInput& in, TickObserver* observer) {
  State& s = *this;
  TickOutput out;
  const auto enter = [observer](TickStage stage) {
    if (observer) observer->Enter(stage);
  };

  // 1 accept
  enter(TickStage::kAccept);
  if (!IsValid(in.X_WT) || !IsInWorld(in.X_WT.p_AB) || !std::isfinite(in.rpm) || !(in.dt_s >= 0) ||
      !std::isfinite(in.dt_s)) {
    s.last = {};
    out.status = kTickBadPose;
    enter(TickStage::kEnd);
    return out;
  }
  if (in.dt_s < kMinTick_s) {
    enter(TickStage::kEnd);
    return s.Repeat();
  }
  const Pose X_to = s.Local(in.X_WT);
  const Pose X_from = std::exchange(s.X_WT, X_to);
  const double rpm = std::abs(in.rpm) < kMinRpm ? 0 : in.rpm;
  EffectBegin begin{in.dt_s, rpm, rpm};
  {
    const EffectsStage stage(observer, s.effects, TickStage::kAccept);
    s.effects.Begin(begin);
  }
  double passes_per_s = s.shape.passes_per_turn * std::abs(begin.rpm) / 60;
  // While a motor slows down, the last tooth has passed more recently than at this speed, and the bite is smaller.
  const double slowing = s.spindle != nullptr && passes_per_s > 0 ? s.spindle->passes_per_s() / passes_per_s : 1;
  passes_per_s *= slowing;
  if (passes_per_s == 0) {
    s.CutRest(X_from);
    out.status = kTickSpindleStopped;
    EffectEnd end{in.dt_s, rpm, 0, s.X_WT, true};
    const EffectsStage stage(observer, s.effects, TickStage::kEnd);
    s.effects.End(end);
    s.last = out;
    enter(TickStage::kEnd);
    return out;
  }
  double substeps = std::max<double>(s.params.substeps, CountSubsteps(X_from, X_to, s.params.tool, s.field.voxel_mm()));
  if (substeps > kMaxSubsteps) {
    out.status |= kTickSubstepsLimited;
    substeps = kMaxSubsteps;
  }

  s.paced.BeginTick();
  // 2 engage and 3 remove, alternately, so that each substep acts on the bone that the previous one has left
  const double dt_s = in.dt_s / substeps;
  const Vec3 p_TG_mm = CalcGrip(s.params.tool);
  TeethSums sums;
  Pose X_a = X_from;
  for (int i = 1; i <= static_cast<int>(substeps); ++i) {
    const Pose X_b = i == static_cast<int>(substeps) ? X_to : Interpolate(X_from, X_to, i / substeps);
    enter(TickStage::kEngage);
    const Twist u = s.CalcTwist(X_a, X_b, dt_s);
    DriveStep stroke;
    double step_passes_per_s = passes_per_s;
    Pose X_edge = X_a;
    if (s.drive.strokes()) {
      stroke = s.drive.CalcStep(s.phase_rad, begin.rpm, dt_s, in.dt_s);
      s.bites = s.drive.CalcBites(s.phase_rad, begin.rpm, dt_s, in.dt_s);
      step_passes_per_s = slowing * s.bites.passes_per_s;
      s.phase_rad = Drive::Advance(s.phase_rad, begin.rpm, dt_s);
      s.problem.edge_mm_per_s = stroke.speed_mm_per_s;
      s.problem.bites = s.bites.span();
      s.edge.SetDisplacement(stroke.middle_mm);
      X_edge = s.shape.motion.Move(X_a, stroke.middle_mm);
    }
    const EdgeLoad load = CallOwn("force law", s.params.law.name(), [&] {
      EdgeLoad step = s.CalcLoad(X_edge, u, step_passes_per_s);
      if (s.edge.met_metal()) out.status |= kTickTouchesMetal;
      if (const double sum_N = step.sums.thrust_N + step.sums.cutting_N; !(sum_N >= 0 && std::isfinite(sum_N))) {
        ThrowBadSum(s.problem, u, sum_N, s.params.law.name());
      }
      if (s.effects.wants_steps()) {
        const EffectsStage stage(observer, s.effects, TickStage::kEngage);
        s.AddEffects(X_a, X_b, u, begin.rpm, dt_s, s.drive.strokes() ? &stroke : nullptr, step);
      }
      return step;
    });
    out.f_T_W_N += X_a.Vector(load.f_T_N);
    out.tau_TG_W_Nmm += X_a.Vector(load.tau_T_Nmm + glm::cross(-p_TG_mm, load.f_T_N));
    sums.Add(load.sums);
    enter(TickStage::kRemove);
    Cutter::Result cut = s.paced.Cut(X_a, X_b, stroke.range);
    out.removed_mm3 += cut.removed_mm3;
    while (cut.out_of_leaves) {
      s.Refill();
      cut = s.paced.Cut(X_a, X_b, stroke.range);
      out.removed_mm3 += cut.removed_mm3;
    }
    X_a = X_b;
  }

  // 4 publish: means over the tick
  enter(TickStage::kPublish);
  sums.Report(substeps, out);
  out.f_T_W_N /= substeps;
  out.tau_TG_W_Nmm /= substeps;
  EffectEnd end{in.dt_s,          rpm,          begin.rpm,      s.X_WT, out.engaged_teeth == 0, out.engaged_teeth,
                out.thrust_sum_N, out.thrust_W, out.removed_mm3};
  {
    const EffectsStage stage(observer, s.effects, TickStage::kPublish);
    s.effects.End(end);
  }
  if (end.f_extra_W_N != Vec3(0)) out.f_T_W_N += end.f_extra_W_N;
  s.last = out;
  enter(TickStage::kEnd);
  return out;
}

}  // namespace kerf
