#include "kerf/coupled.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cut/contact/broken_rule.h"
#include "cut/hand_sim/internals.h"
#include "cut/hand_sim/state.h"

namespace kerf {
namespace {

constexpr double kMaxTick_s = 1;
constexpr double kMaxSpeed = 1e6;  // of the handle, mm/s and rad/s

bool IsFinite(const Vec3& v, double limit) {
  return std::abs(v.x) <= limit && std::abs(v.y) <= limit && std::abs(v.z) <= limit;
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
         std::abs(in.rpm) <= std::max(kMaxRpm, CalcRateRange(params.tool).upper);
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

/// Removes all bone inside the tool in the first tick with a turning spindle. The flats do not cut afterwards, so bone
/// in contact with them would hold the tool.
void CoupledSimulation::State::CutAtStart(CoupledOutput& out) {
  if (!at_start) return;
  const Cutter::Result cut = cutter.CutAround(X_WT, {-0.5 * CalcStroke(params.tool), 0.5 * CalcStroke(params.tool)});
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

CoupledOutput CoupledSimulation::Tick(const CoupledInput& input, TickObserver* observer) {
  State& s = *state_;
  ++s.ticks;
  const Pose X_WT_before = s.X_WT, X_WH_before = s.X_WH;
  const double phase_before = s.phase_rad;
  const PacedCutter paced_before = s.paced;
  const bool at_start_before = s.at_start;
  try {
    return CallOwn("force law", s.params.law.name(), [&] { return s.Tick(input, observer); });
  } catch (BrokenRule& fault) {
    s.X_WT = X_WT_before;
    s.X_WH = X_WH_before;
    s.phase_rad = phase_before;
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
  in.X_WH = s.Local(WithUnitRotation(in.X_WH));
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
  // The hand's force is steady within a stroke, and so is then the bite that its teeth cut on their way: that is the
  // floor which the last pass has left, whose memory needs no state (docs/physics.md).
  s.problem.passes_per_s =
      s.drive.strokes() ? s.drive.CalcPassRate(in.rpm) : s.shape.passes_per_turn * std::abs(in.rpm) / 60;

  s.tick_s = in.dt_s;
  const double first_rad = s.phase_rad;

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
  s.phase_rad = Drive::Advance(first_rad, in.rpm, in.dt_s);

  // 6 effects of the whole tick
  const double mean = sums.time_s > 0 ? 1 / sums.time_s : 0;
  EffectEnd end{in.dt_s,
                input.rpm,
                in.rpm,
                s.X_WT,
                (out.status & kCoupledAsleep) != 0,
                mean * sums.teeth.teeth,
                mean * sums.teeth.thrust_N,
                mean * sums.teeth.thrust_W,
                out.removed_mm3};
  {
    const EffectsStage stage(observer, s.effects, TickStage::kPublish);
    s.effects.End(end);
  }

  // 7 publish
  enter(TickStage::kPublish);
  s.Publish(sums, out);
  if (s.drive.strokes()) out.displacement_mm = s.drive.CalcDisplacement(s.phase_rad);
  if (end.f_extra_W_N != Vec3(0)) out.f_H_W_N += end.f_extra_W_N;
  // If tool and handle coincide, the output has the input's position, without the rounding of the frame change.
  if (s.X_WT.p_AB == in.X_WH.p_AB && s.X_WT.R_AB == in.X_WH.R_AB) out.X_WT.p_AB = input.X_WH.p_AB;
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
  s.last = {};
  s.last.X_WT = WithUnitRotation(X_WT);
  s.X_WT = s.Local(s.last.X_WT);
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

StepWork CoupledInternals::Work(const CoupledSimulation& simulation) {
  const CoupledSimulation::State& s = *simulation.state_;
  return {s.cutter.effort(), s.edge.samples() + s.faces.samples(), s.field.spare_leaves()};
}
Pose CoupledInternals::ToolPose(const CoupledSimulation& simulation) {
  return simulation.state_->last.X_WT;
}
void CoupledInternals::SupplyLeaves(CoupledSimulation& simulation, int least) {
  simulation.state_->field.Supply(std::max(simulation.state_->params.spare_leaves, least));
}
void CoupledInternals::ClearChanged(CoupledSimulation& simulation, int first) {
  simulation.state_->field.ClearChanged(first);
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
