#include "loop/haptics/step_body.h"

#include <utility>

#include "cut/effects/plan.h"

namespace kerf {

StepBody::StepBody(CoupledSimulation& simulation, GuardedDevice& device, const StepBodyParams& params,
                   HandDriver* before)
    : simulation_(simulation),
      device_(device),
      params_(params),
      rpm_(params.rpm),
      before_(before),
      step_(simulation, device.profile(), params.force_map) {}

std::size_t StepBody::channel_count() const {
  return std::as_const(simulation_).effects().channel_count();
}
void StepBody::ReportChannels(std::span<double> channels) const {
  std::as_const(simulation_).effects().Report(channels);
}

bool StepBody::Tick(double dt_s, TickObserver& observer, LoopTick& report) {
  if (before_ != nullptr) before_->Advance(dt_s);
  HapticStepInput in;
  in.dt_s = dt_s;
  in.slew_dt_s = params_.period_s;
  in.rpm = rpm_.load(std::memory_order_relaxed);
  in.force_off = force_off_;
  force_off_ = false;
  report.inputs.force_off = in.force_off;
  report.inputs.dt_s = dt_s;
  report.inputs.rpm = in.rpm;
  report.inputs.fidelity = simulation_.fidelity();
  report.inputs.restore = {};
  if (restores_ != nullptr) {
    report.inputs.restore = restores_->Begin(simulation_, pieces_ != nullptr && pieces_->leaving());
    in.stand = restores_->running();
    // A piece that was found in the old bone is not valid in the restored one.
    if (in.stand && pieces_ != nullptr) pieces_->Drop();
  }
  report.stands = in.stand;
  const HapticStepOutput out = step_.Step(device_, in, &observer);
  report.inputs.sample = out.exchange.sample;
  report.inputs.read = out.exchange.read;
  report.inputs.wrote = out.exchange.wrote;
  report.inputs.piece = 0;
  if (in.stand) {
    if (restores_->Step(simulation_)) restores_->End(simulation_, step_.has_sample() ? &out.sample.X_WH : nullptr);
    if (pieces_ != nullptr) pieces_->Pass();
  } else if (pieces_ != nullptr) {
    report.inputs.piece = pieces_->Step(simulation_);
  }
  if (hash_ != nullptr) {
    for (int i = 0; i < simulation_.changed_count(); ++i) hash_->Take(simulation_.changed(i));
    // No hash while bone is restored: the order in which voxels are restored depends on when the request was made.
    if (!in.stand) report.voxel_hash = hash_->value();
  }
  report.X_WH = out.sample.X_WH;
  report.f_device_N = out.force.f_H_W_N;
  report.out = out.coupled;
  if (in.stand && step_.has_sample()) {
    report.out.X_WT = out.sample.X_WH;  // where the tool is placed
  } else if ((out.faults & (kHapticReadFailed | kHapticBadSample)) != 0 && X_WT_) {
    report.out.X_WT = *X_WT_;  // the tool is stopped
  }
  X_WT_ = report.out.X_WT;
  failed_s_ = (out.faults & (kHapticReadFailed | kHapticWriteFailed)) != 0 ? failed_s_ + dt_s : 0;
  return failed_s_ <= params_.give_up_s;
}

}  // namespace kerf
