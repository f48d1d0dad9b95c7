#include "loop/haptics/haptic_step.h"

#include "base/core/vectors.h"
#include "device/devices/lattice.h"

namespace kerf {
namespace {

constexpr double kTurningQuantum_rad = 1e-4;  // quantum of a sensed orientation: 0.006 degrees, finer than any gimbal
constexpr double kTurningReach_mm = 100;      // distance from the wrist to the tool

/// Returns the rotation vector from a to b in the world frame, rad.
Vec3 CalcRotationAngle(const Quat& a, const Quat& b) {
  Quat q = b * glm::conjugate(a);
  if (q.w < 0) q = -q;
  const Vec3 axis(q.x, q.y, q.z);
  const double sine = glm::length(axis);
  return sine > 1e-12 ? axis * (2 * std::atan2(sine, q.w) / sine) : 2.0 * axis;
}

}  // namespace

HapticStep::HapticStep(CoupledSimulation& simulation, const DeviceProfile& profile, const ForceMapParams& force_map)
    : simulation_(&simulation),
      force_map_(profile, force_map),
      // Rounding to the lattice shifts a sample slightly off the encoder's counts.
      velocity_(profile.resolution_mm > 0 ? profile.resolution_mm + 4 * kLatticePosition_mm : 4 * kLatticePosition_mm),
      turning_(kTurningQuantum_rad, 16, kTurningReach_mm) {}

bool HapticStep::ReadHandle(Device& device, HapticTick& out) {
  DeviceSample sample;
  const bool read = device.Read(sample);
  const bool good = read && IsValid(sample.X_WH) && IsInWorld(sample.X_WH.p_AB);
  // A pose on the lattice is unchanged, so a recorded pose is reproduced bit for bit.
  if (good && !FindOnLattice(sample.X_WH)) sample.X_WH = MakePose(FindNearestOnLattice(sample.X_WH));
  out.in.X = sample.X_WH;
  out.in.buttons = sample.buttons;
  if (!read) {
    out.in.flags |= kRecordedReadFailed;
    out.faults |= kHapticReadFailed;
    ++counts_.read_failed;
  } else if (!good) {
    out.faults |= kHapticBadSample;
    ++counts_.bad_samples;
  }
  if ((out.in.flags & kRecordedCarried) != 0) {
    // This motion is not one of a hand.
    velocity_.Reset();
    turning_.Reset();
  }
  if (good) {
    const Vec3& p_TC = simulation_->params().coupling.p_TC_mm;
    if (has_pose_) turned_W_rad_ += CalcRotationAngle(X_WH_.R_AB, sample.X_WH.R_AB);
    velocity_.Update(sample.X_WH.Point(p_TC), out.in.dt_s);
    turning_.Update(turned_W_rad_, out.in.dt_s);
    X_WH_ = sample.X_WH;
    has_pose_ = true;
  } else {
    // After a gap, the next sample would look like a jump at high speed.
    velocity_.Reset();
    turning_.Reset();
  }
  out.X_WH = X_WH_;
  out.v_H_W_mm_per_s = velocity_.velocity();
  out.w_H_W_rad_per_s = turning_.velocity();
  return good;
}

void HapticStep::Simulate(TickObserver* observer, HapticTick& out) {
  CoupledInput tick;
  tick.X_WH = X_WH_;
  tick.v_H_W_mm_per_s = out.v_H_W_mm_per_s;
  tick.w_H_W_rad_per_s = out.w_H_W_rad_per_s;
  tick.dt_s = out.in.dt_s;
  tick.rpm = out.in.rpm;
  out.coupled = simulation_->Tick(tick, observer);
  const bool finite = IsFinite(out.coupled.f_H_W_N) && IsFinite(out.coupled.tau_H_W_Nmm);
  if (!finite || (out.coupled.status & kCoupledBadPose) != 0) {
    out.faults |= kHapticBadForce;
    ++counts_.bad_forces;
  }
}

HapticTick HapticStep::Step(Device& device, const TickInputs& in, TickObserver* observer, bool stands) {
  HapticTick out;
  out.in = in;
  device.Elapse(in.dt_s);
  if ((in.flags & kRecordedForceOff) != 0) out.faults |= kHapticForceOff;
  // A failed write in the last tick is a fault of this tick, so that the force is ramped in again.
  if (write_failed_) out.faults |= kHapticWriteFailed;

  const bool has_new_pose = ReadHandle(device, out);
  if (has_new_pose && !stands) Simulate(observer, out);
  out.force =
      force_map_.Calc(out.coupled.f_H_W_N, out.coupled.tau_H_W_Nmm, in.dt_s, out.faults != kHapticOk, slew_dt_s_);
  if (stands) force_map_.BeginRamp();
  write_failed_ = !device.Write(out.force.f_H_W_N, out.force.tau_H_W_Nmm);
  if (write_failed_) {
    out.in.flags |= kRecordedWriteFailed;
    out.faults |= kHapticWriteFailed;
    ++counts_.write_failed;
    out.force.f_H_W_N = out.force.tau_H_W_Nmm = Vec3{0};
    out.force.status |= kForceMapFault;
  }
  return out;
}

}  // namespace kerf
