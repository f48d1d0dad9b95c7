#include "haptics/step_body.h"

#include <utility>

#include "effects/plan.h"

namespace kerf {

StepBody::StepBody(CoupledSimulation& simulation, GuardedDevice& device, const StepBodyParams& params,
                   BeforeTick* before)
    : simulation_(simulation),
      device_(device),
      params_(params),
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
  in.rpm = params_.rpm;
  in.force_off = force_off_;
  force_off_ = false;
  const HapticStepOutput out = step_.Step(device_, in, &observer);
  if (pieces_ != nullptr) pieces_->Step(simulation_);
  report.X_WH = out.sample.X_WH;
  report.f_device_N = out.force.f_H_W_N;
  report.out = out.coupled;
  failed_s_ = (out.faults & (kHapticReadFailed | kHapticWriteFailed)) != 0 ? failed_s_ + dt_s : 0;
  return failed_s_ <= params_.give_up_s;
}

}  // namespace kerf
