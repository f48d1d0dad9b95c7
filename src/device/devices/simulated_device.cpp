#include "device/devices/simulated_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/core/vectors.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kMaxTick_s = 0.1;
constexpr double kReturn_s = 0.5;    // time constant with which a yielded position returns
constexpr double kForget_rad = 3.0;  // maximum rotation of the handle in the hand, beyond which the grip slips

Vec3 Shorten(const Vec3& v, double limit, bool& shortened) {
  const double length = std::hypot(v.x, v.y, v.z);
  if (length <= limit) return v;
  shortened = true;
  return std::isfinite(length) ? v * (limit / length) : Vec3{0};
}

Quat MakeRotation(const Vec3& rotation_rad) {
  const double angle = glm::length(rotation_rad);
  return angle > 0 ? glm::angleAxis(angle, rotation_rad / angle) : Quat{1, 0, 0, 0};
}

}  // namespace

SimulatedDevice::SimulatedDevice(const DeviceProfile& profile, const HandModel& hand, const Pose& X_WH_start,
                                 const SimulatedDeviceOptions& options)
    : profile_(profile), hand_(hand), options_(options) {
  if (!(profile.mass_kg > 0)) throw Error(fmt::format("device {} has no mass; it can't be simulated", profile.name));
  if (!IsValid(X_WH_start) || !IsInWorld(X_WH_start.p_AB)) {
    throw Error("the start pose of the simulated device is not valid or outside the world");
  }
  CheckParameters(options, "simulated device");
  Place(X_WH_start);
  last_sample_.X_WH = X_WH_start;
}

void SimulatedDevice::SetScript(IntentionScript script) {
  script_ = std::move(script);
  script_start_s_ = time_s_;
  intention_ = script_->Calc(0);
}

void SimulatedDevice::SetIntention(const Intention& intention) {
  script_.reset();
  intention_ = intention;
}

void SimulatedDevice::Place(const Pose& X_WH) {
  SetIntention({.X_WH = X_WH});
  p_WC_mm_ = X_WH.Point(options_.p_TC_mm);
  v_WC_mm_per_s_ = yielded_mm_ = turned_W_rad_ = Vec3{0};
}

Quat SimulatedDevice::CalcOrientation() const noexcept {
  return glm::normalize(MakeRotation(turned_W_rad_) * intention_.X_WH.R_AB);
}

void SimulatedDevice::Integrate(double h) noexcept {
  if (script_) {
    intention_ = script_->Calc(time_s_ + 0.5 * h - script_start_s_);
  } else {
    intention_.X_WH.p_AB += h * intention_.v_W_mm_per_s;
  }
  const Vec3 wanted_p = intention_.X_WH.Point(options_.p_TC_mm) + yielded_mm_;
  const double m = 1e-3 * (profile_.mass_kg + hand_.mass_kg);  // N s^2 / mm
  const double b_hand = hand_.damping_Ns_per_mm;
  const double b = b_hand + profile_.own_damping_Ns_per_mm;
  const double k = hand_.stiffness_N_per_mm;
  // Implicit midpoint: v1 = v0 + h/m (f - b (v0+v1)/2 - k (x0 + h/4 (v0+v1) - x_wanted)).
  const Vec3 v0 = v_WC_mm_per_s_;
  const Vec3 f = f_W_N_ + intention_.push_W_N + b_hand * intention_.v_W_mm_per_s - k * (p_WC_mm_ - wanted_p);
  const double drag = 0.5 * h * b / m + 0.25 * h * h * k / m;
  Vec3 v1 = ((1 - drag) * v0 + (h / m) * f) / (1 + drag);
  // Friction reduces the speed and never reverses it, so that a sticking handle stays exactly in place.
  const double speed = glm::length(v1);
  const double taken = profile_.friction_N * h / m;
  const Vec3 v_free = v1;
  v1 = speed > taken ? v1 * (1 - taken / speed) : Vec3{0};
  const Vec3 moved = 0.5 * h * (v0 + v1);
  lost_mJ_ += glm::dot(0.5 * profile_.own_damping_Ns_per_mm * (v0 + v_free) + (m / h) * (v_free - v1), moved);
  p_WC_mm_ += moved;
  v_WC_mm_per_s_ = v1;
  port_mJ_ -= glm::dot(f_W_N_, moved);

  const double push = glm::length(intention_.push_W_N);
  if (intention_.yield_s > 0 && push > 0) {
    const Vec3 along = intention_.push_W_N / push;
    yielded_mm_ += (-std::expm1(-h / intention_.yield_s)) * glm::dot(p_WC_mm_ - wanted_p, along) * along;
  } else {
    yielded_mm_ *= std::exp(-h / kReturn_s);
  }
}

void SimulatedDevice::Elapse(double dt_s) noexcept {
  if (!(dt_s > 0)) return;
  const double dt = std::min(dt_s, kMaxTick_s);
  const double h = dt / options_.substeps;
  for (int i = 0; i < options_.substeps; ++i) {
    Integrate(h);
    time_s_ += h;
  }
  // Rotation: c w = tau - k turned, which is solved exactly for a constant torque.
  if (hand_.torsion_Nmm_per_rad > 0 && hand_.torsion_damping_Nmms > 0) {
    const Vec3 before = turned_W_rad_;
    const double stays = std::exp(-dt * hand_.torsion_Nmm_per_rad / hand_.torsion_damping_Nmms);
    turned_W_rad_ = stays * before + (1 - stays) / hand_.torsion_Nmm_per_rad * tau_W_Nmm_;
    const double angle = glm::length(turned_W_rad_);
    if (angle > kForget_rad) turned_W_rad_ *= kForget_rad / angle;
    port_mJ_ -= glm::dot(tau_W_Nmm_, turned_W_rad_ - before);
  } else {
    turned_W_rad_ = Vec3{0};
  }
}

bool SimulatedDevice::Read(DeviceSample& sample) noexcept {
  if (faults_.read_fails) return false;
  if (!faults_.frozen) {
    Vec3 p_WC = p_WC_mm_;
    if (options_.quantise && profile_.resolution_mm > 0) {
      for (int i = 0; i < 3; ++i) p_WC[i] = std::round(p_WC[i] / profile_.resolution_mm) * profile_.resolution_mm;
    }
    last_sample_.X_WH.R_AB = CalcOrientation();
    last_sample_.X_WH.p_AB = p_WC + faults_.jump_mm - last_sample_.X_WH.Vector(options_.p_TC_mm);
  }
  sample = last_sample_;
  if (faults_.not_a_number) sample.X_WH.p_AB.x = std::numeric_limits<double>::quiet_NaN();
  return true;
}

bool SimulatedDevice::Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept {
  if (faults_.write_fails || !IsFinite(f_H_W_N) || !IsFinite(tau_H_W_Nmm)) {
    queue_.fill({});
    f_W_N_ = tau_W_Nmm_ = Vec3{0};
    return false;
  }
  bool shortened = false;
  const bool turns = profile_.degrees_of_freedom == 6;
  const Wrench wrench{Shorten(f_H_W_N, profile_.peak_force_N, shortened),
                      turns ? Shorten(tau_H_W_Nmm, profile_.peak_torque_Nmm, shortened) : Vec3{0}};
  if (shortened) ++saturated_writes_;
  queue_at_ = (queue_at_ + 1) % (kMaxDelay_ticks + 1);
  queue_[static_cast<std::size_t>(queue_at_)] = wrench;
  const int from = (queue_at_ + kMaxDelay_ticks + 1 - options_.delay_ticks) % (kMaxDelay_ticks + 1);
  f_W_N_ = queue_[static_cast<std::size_t>(from)].f_W_N;
  tau_W_Nmm_ = queue_[static_cast<std::size_t>(from)].tau_W_Nmm;
  return true;
}

}  // namespace kerf
