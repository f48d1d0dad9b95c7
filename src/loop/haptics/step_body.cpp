#include "loop/haptics/step_body.h"

#include <utility>

#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"

namespace kerf {

bool Touches(const CoupledOutput& out) {
  // In air the coupling's load is zero, apart from rounding.
  constexpr double kTouch_N = 0.02;
  constexpr double kTouch_Nmm = 0.5;
  return glm::length(out.f_H_W_N) > kTouch_N || glm::length(out.tau_H_W_Nmm) > kTouch_Nmm;
}

StepBody::StepBody(CoupledSimulation& simulation, GuardedDevice& device, const StepBodyParams& params,
                   HandDriver* before)
    : simulation_(simulation),
      device_(device),
      params_(params),
      rpm_(params.rpm),
      before_(before),
      step_(simulation, device.profile(), params.force_map) {
  step_.set_slew_dt_s(params.period_s);
}

std::size_t StepBody::channel_count() const {
  return EffectsOf(std::as_const(simulation_)).channel_count();
}
void StepBody::ReportChannels(std::span<double> channels) const {
  EffectsOf(std::as_const(simulation_)).Report(channels);
}

void StepBody::ClearChanged(int first) {
  kerf::ClearChanged(simulation_, first);
}

bool StepBody::Tick(double dt_s, TickObserver& observer, LoopTick& tick) {
  if (before_ != nullptr) {
    if (X_WT_) before_->Follow(*X_WT_, touches_, turns_);
    before_->Advance(dt_s);
  }
  TickInputs in;
  in.dt_s = dt_s;
  in.rpm = rpm_.load(std::memory_order_relaxed);
  in.fidelity = static_cast<std::uint8_t>(simulation_.fidelity());
  if (std::exchange(force_off_, false)) in.flags |= kRecordedForceOff;
  tick.stands = false;
  if (restores_ != nullptr) {
    const Pose* X_carried =
        restores_->Begin(simulation_, X_WT_ ? &*X_WT_ : nullptr, pieces_ != nullptr && pieces_->leaving(), in);
    if (X_carried != nullptr && before_ != nullptr) before_->Place(*X_carried);
    tick.stands = restores_->running();
    // A piece that was found in the old bone is not valid in the restored one.
    if (tick.stands && pieces_ != nullptr) pieces_->Drop();
  }
  tick.held = before_ == nullptr || before_->holds();
  static_cast<HapticTick&>(tick) = step_.Step(device_, in, &observer, tick.stands);
  if (tick.stands) {
    restores_->Step(simulation_, step_.has_pose() ? &tick.X_WH : nullptr);
    if (pieces_ != nullptr) pieces_->Pass();
  } else if (pieces_ != nullptr) {
    tick.in.piece = pieces_->Step(simulation_);
    if (tick.in.piece != 0) tick.in.flags |= kRecordedPieceLeaves;
  }
  if (hash_ != nullptr) {
    for (int i = 0; i < simulation_.changed_count(); ++i) hash_->Take(simulation_.changed(i));
    // No hash while bone is restored: the order in which voxels are restored depends on when the request was made.
    if (!tick.stands) tick.voxel_hash = hash_->value();
  }
  if (tick.stands && step_.has_pose()) {
    tick.coupled.X_WT = tick.X_WH;  // where the tool is placed
  } else if ((tick.faults & (kHapticReadFailed | kHapticBadSample)) != 0) {
    // The tool is stopped. Nothing has moved it until a device is in the hand for the first time.
    tick.coupled.X_WT = X_WT_.value_or(CoupledInternals::ToolPose(simulation_));
  }
  X_WT_ = tick.coupled.X_WT;
  if (step_.has_pose()) device_.TakeToolPose(*X_WT_);
  touches_ = Touches(tick.coupled);
  turns_ = in.rpm != 0;
  failed_s_ = (tick.faults & (kHapticReadFailed | kHapticWriteFailed)) != 0 ? failed_s_ + dt_s : 0;
  return failed_s_ <= params_.give_up_s;
}

}  // namespace kerf
