#include "experiment/stability/closed_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "kerf/error.h"
#include "loop/haptics/haptic_loop.h"

namespace kerf {
namespace {

constexpr double kNormal999 = 3.090232306167813;  // a standard normal variate is below it with probability 0.999
constexpr double kShortestPeriod = 0.25;          // minimum interval between ticks, in periods, as in Deadlines
constexpr double kLongestPeriod_s = 10;

ClosedLoopSetup Checked(ClosedLoopSetup setup) {
  CheckParameters(setup, "closed loop");
  return setup;
}

TimingFaults Checked(const TimingFaults& timing, double period_s) {
  CheckParameters(timing, "closed loop");
  if (timing.tail_p999_s != 0) CheckRange("tail_p999_s", timing.tail_p999_s, {period_s, 1}, "closed loop");
  return timing;
}

/// Returns the profile with motors strong enough for the tested gain.
DeviceProfile Strengthen(DeviceProfile profile, double gain) {
  profile.peak_force_N *= std::max(1.0, gain);
  profile.peak_torque_Nmm *= std::max(1.0, gain);
  return profile;
}

SimulatedDeviceOptions MakeOptions(const ClosedLoopSetup& setup) {
  SimulatedDeviceOptions options;
  options.p_TC_mm = setup.coupled.coupling.p_TC_mm;
  options.delay_ticks = setup.delay_ticks;
  options.quantise = setup.quantise;
  return options;
}

/// A device whose motors output `gain` times the commanded force. Its time is advanced by the loop, not by the tick.
class GainDevice final : public Device {
 public:
  GainDevice(Device& device, double gain) : device_(device), gain_(gain) {}
  const DeviceProfile& profile() const override { return device_.profile(); }
  bool Read(DeviceSample& sample) noexcept override { return device_.Read(sample); }
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override {
    return device_.Write(gain_ * f_H_W_N, gain_ * tau_H_W_Nmm);
  }

 private:
  Device& device_;
  double gain_;
};

}  // namespace

struct ClosedLoop::State {
  State(Bone bone, const ClosedLoopSetup& the_setup, const Pose& X_WH)
      : setup(the_setup),
        X_WH_start(X_WH),
        simulation(std::move(bone), setup.coupled, X_WH),
        device(Strengthen(setup.profile, setup.loop_gain), setup.hand, X_WH, MakeOptions(setup)),
        motors(device, setup.loop_gain),
        step(simulation, setup.profile, setup.force_map),
        p_read_mm(device.p_WC_mm()) {
    step.set_slew_dt_s(setup.period_s);
    device.SetIntention({.X_WH = X_WH});
    tick.p_WC_mm = p_read_mm;
  }

  double Uniform() { return static_cast<double>(random() >> 11U) * 0x1p-53; }
  double DrawPeriod();
  bool DrawLost(double from_s);
  void Elapse(double time_s);
  void Tick(double rpm);
  void Account();

  ClosedLoopSetup setup;
  Pose X_WH_start;
  CoupledSimulation simulation;
  SimulatedDevice device;
  GainDevice motors;
  HapticStep step;
  TimingFaults timing;
  std::mt19937_64 random{1};
  double since_tick_s = 0;  // time since the last tick began
  bool tripped = false;     // by the watchdog, since the last tick
  Vec3 p_read_mm;           // position of the handle in the last tick
  ClosedLoopTick tick;
};

ClosedLoop::ClosedLoop(Bone bone, const ClosedLoopSetup& setup, const Pose& X_WH_start)
    : state_(std::make_unique<State>(std::move(bone), Checked(setup), X_WH_start)) {}
ClosedLoop::~ClosedLoop() = default;

double ClosedLoop::State::DrawPeriod() {
  double period = 1;
  if (timing.jitter > 0) period += timing.jitter * (2 * Uniform() - 1);
  if (timing.tail_p999_s > 0) {
    const double sigma = std::log(timing.tail_p999_s / setup.period_s) / kNormal999;
    const double radius = std::sqrt(-2 * std::log(1 - Uniform()));
    period *= std::exp(sigma * radius * std::cos(2 * std::numbers::pi * Uniform()));
  }
  return std::min(kLongestPeriod_s, setup.period_s * std::max(period, kShortestPeriod));
}

bool ClosedLoop::State::DrawLost(double from_s) {
  // This is drawn in any case, so that the losses do not depend on the bursts.
  const bool lost = timing.lost_share > 0 && Uniform() < timing.lost_share;
  if (!(timing.burst_every_s > 0)) return lost;
  const double start_s = std::floor(from_s / timing.burst_every_s) * timing.burst_every_s;
  return lost || (start_s > 0 && from_s - start_s < timing.burst_s);
}

/// Advances hand and handle under the current force of the motors.
void ClosedLoop::State::Elapse(double time_s) {
  const int parts = static_cast<int>(std::ceil(time_s / setup.period_s - 1e-9));
  for (int i = 0; i < parts; ++i) {
    const double before_mJ = device.port_mJ();
    device.Elapse(time_s / parts);
    tick.energy.exchanged_mJ += std::abs(device.port_mJ() - before_mJ);
    Account();
  }
}

void ClosedLoop::State::Account() {
  PortEnergy& e = tick.energy;
  const Vec3& v = device.v_WC_mm_per_s();
  e.motor_mJ = device.port_mJ();
  e.handle_mJ = e.motor_mJ + device.lost_mJ() + 0.5e-3 * device.profile().mass_kg * glm::dot(v, v);
  e.lowest_mJ = std::min(e.lowest_mJ, e.motor_mJ + e.spindle_mJ);
  e.lowest_handle_mJ = std::min(e.lowest_handle_mJ, e.handle_mJ + e.spindle_mJ);
}

void ClosedLoop::State::Tick(double rpm) {
  // As in HapticLoop, a tick advances by whole periods, but by at most 10 ms.
  const double periods = std::max(1.0, std::round(since_tick_s / setup.period_s));
  tick.dt_s = std::min(periods * setup.period_s, std::max(kMaxTickDt_s, setup.period_s));
  const Vec3 f_before = device.force_N();
  tick.out = step.Step(motors, {.dt_s = tick.dt_s, .rpm = rpm, .flags = tripped ? kRecordedForceOff : 0u});

  const double scale = setup.loop_gain * step.force_map().force_scale();
  const double K = scale * setup.coupled.coupling.stiffness_N_per_mm;
  const Vec3 moved = device.p_WC_mm() - p_read_mm;
  if (f_before != Vec3{0} || device.force_N() != Vec3{0}) tick.energy.held_mJ += 0.5 * K * glm::dot(moved, moved);
  p_read_mm = device.p_WC_mm();
  tick.energy.spindle_mJ += scale * tick.out.coupled.spindle_mJ;
  since_tick_s = 0;
  tripped = false;
}

ClosedLoopTick ClosedLoop::Step(double rpm) {
  State& s = *state_;
  const double period_s = s.DrawPeriod();
  const bool lost = s.DrawLost(s.tick.time_s + period_s);
  const double limit_s = 1e-3 * s.setup.watchdog_ms;
  const double left_s = std::max(limit_s - s.since_tick_s, 0.0);  // until the watchdog trips
  if (s.tripped) {
    s.device.Write(Vec3{0}, Vec3{0});  // again, so that the zero force passes through the delay
    s.Elapse(period_s);
  } else if (period_s > left_s * (1 + 1e-9)) {
    s.Elapse(left_s);
    s.tripped = true;
    s.device.Write(Vec3{0}, Vec3{0});
    s.Elapse(period_s - left_s);
  } else {
    s.Elapse(period_s);
  }
  s.since_tick_s += period_s;
  s.tick.time_s += period_s;
  s.tick.f_device_N = s.device.force_N();
  s.tick.dt_s = 0;
  if (!lost) s.Tick(rpm);
  s.Account();
  s.tick.p_WC_mm = s.device.p_WC_mm();
  s.tick.v_WC_mm_per_s = s.device.v_WC_mm_per_s();
  return s.tick;
}

SimulatedDevice& ClosedLoop::device() {
  return state_->device;
}
void ClosedLoop::SetTiming(const TimingFaults& timing) {
  state_->timing = Checked(timing, state_->setup.period_s);
  state_->random.seed(timing.seed);
}
CoupledSimulation& ClosedLoop::simulation() {
  return state_->simulation;
}
const ClosedLoopSetup& ClosedLoop::setup() const {
  return state_->setup;
}
const Pose& ClosedLoop::X_WH_start() const {
  return state_->X_WH_start;
}

}  // namespace kerf
