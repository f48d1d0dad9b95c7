#include "cut/effects/spindle/spindle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"
#include "cut/effects/plan.h"
#include "cut/effects/tangential_force.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kRpm = 30 / std::numbers::pi;
constexpr double kMax_Nmm = 1e9;

}  // namespace

SpindleEffect::SpindleEffect(const SpindleParams& params, TangentialForceEffect& cutting, const EffectSetup& setup)
    : motor_{.stall_torque_Nmm = params.stall_torque_Nmm,
             .no_load_rad_per_s = params.no_load_rpm / kRpm,
             .inertia_gmm2 = params.inertia_gmm2,
             .friction_Nmm = params.friction_Nmm,
             .viscous_Nmms = params.viscous_Nmms,
             .brakes = params.brakes},
      follows_(!(params.no_load_rpm >= kMinRpm)),
      restart_fraction_(params.restart_share),
      cutting_(cutting),
      spin_{-setup.p_TC_mm.y, setup.p_TC_mm.x, 0, 0, 0, 1},
      is_coupled_(setup.faces != nullptr),
      passes_per_turn_(setup.shape.passes_per_turn) {
  if (follows_) motor_.no_load_rad_per_s = 1;
}

const SpindleEffect& SpindleEffect::In(const EffectPlan& plan) {
  const Effect* effect = plan.Find("spindle");
  if (effect == nullptr) throw Error("the effect spindle is not enabled");
  return static_cast<const SpindleEffect&>(*effect);
}

void SpindleEffect::Begin(EffectBegin& begin) {
  const bool on = std::abs(begin.set_rpm) >= kMinRpm;
  if (!on && w_rad_per_s_ == 0) {
    // Off, and at rest.
    load_Nmm_ = hold_Nmm_ = load_Nmms_ = hold_Nmms_ = 0;
    stalled_ = false;
    run_ = {};
    begin.rpm = 0;
    was_stopped_ = true;
    cutting_.SetHoldingTorque(0);
    CountPasses(0, begin.dt_s);
    return;
  }
  double set = on ? std::clamp(begin.set_rpm, -kMaxRpm, kMaxRpm) / kRpm : 0;
  if (follows_) {
    if (on) motor_.no_load_rad_per_s = std::abs(set);
  } else {
    set = std::clamp(set, -motor_.no_load_rad_per_s, motor_.no_load_rad_per_s);
  }
  const double inv = dt_s_ > 0 ? 1 / dt_s_ : 0;
  load_Nmm_ = std::clamp(inv * load_Nmms_, 0.0, kMax_Nmm);
  hold_Nmm_ = was_stopped_ ? std::clamp(inv * hold_Nmms_, 0.0, kMax_Nmm) : load_Nmm_;
  load_Nmms_ = hold_Nmms_ = 0;
  dt_s_ = begin.dt_s;

  double hold = hold_Nmm_;
  if (stalled_) hold = is_coupled_ ? hold / restart_fraction_ : std::numeric_limits<double>::infinity();
  run_ = RunMotor(motor_, set, load_Nmm_, hold, w_rad_per_s_, begin.dt_s);
  w_rad_per_s_ = run_.w_rad_per_s;
  stalled_ = on && w_rad_per_s_ == 0;
  begin.rpm = run_.angle_rad / begin.dt_s * kRpm;
  // In the tick in which the spindle stalls, a very low mean speed would give an arbitrary bite.
  if (stalled_ || std::abs(begin.rpm) < kMinRpm) begin.rpm = 0;
  was_stopped_ = begin.rpm == 0;
  CountPasses(begin.rpm, begin.dt_s);
  const double push_Nmm = stalled_ ? motor_.CalcTorque(set, 0) : 0;
  cutting_.SetHoldingTorque(std::copysign(std::max(0.0, std::abs(push_Nmm) - motor_.friction_Nmm), push_Nmm));
}

/// Advances the time since a tooth last passed; exact at constant speed.
void SpindleEffect::CountPasses(double rpm, double dt_s) {
  const double rate_per_s = passes_per_turn_ * std::abs(rpm) / 60;
  if (rate_per_s == 0) {
    since_pass_s_ = passes_per_s_ = 0;
    return;
  }
  const double lasting_s = 1 / rate_per_s;
  const double passes = rate_per_s * dt_s;
  const double change = -std::expm1(-passes);
  passes_per_s_ = 1 / (lasting_s + (since_pass_s_ - lasting_s) * change / passes);
  since_pass_s_ += (lasting_s - since_pass_s_) * change;
}

void SpindleEffect::Solved(const EffectSolved& solved) {
  const StepProblem& problem = solved.problem;
  if (solved.rpm == 0) {
    double hold_Nmm = cutting_.CalcRequiredTorque();
    const Twist spin = solved.stroke != nullptr ? Twist{0, cutting_.lever_mm(), 0, 0, 0, 0} : spin_;
    for (const FrictionPoint& p : problem.frictions) {
      if (p.slip_a_mm_per_s != 0 || p.slip_b_mm_per_s != 0) continue;  // caused by the motor's own torque
      hold_Nmm += p.limit_N * std::hypot(Dot(p.row_a, spin), Dot(p.row_b, spin));
    }
    hold_Nmms_ += solved.time_s * hold_Nmm;
    return;
  }
  const double creep2 = problem.creep_mm_per_s * problem.creep_mm_per_s;
  double power = 0;  // mJ/s
  for (const FrictionPoint& p : problem.frictions) {
    const double a = Dot(p.row_a, solved.u) + p.slip_a_mm_per_s;
    const double b = Dot(p.row_b, solved.u) + p.slip_b_mm_per_s;
    power += p.limit_N * (a * p.slip_a_mm_per_s + b * p.slip_b_mm_per_s) / std::sqrt(a * a + b * b + creep2);
  }
  load_Nmms_ += solved.time_s * power / (std::abs(solved.rpm) / kRpm);
}

double SpindleEffect::rpm() const {
  return w_rad_per_s_ * kRpm;
}

void SpindleEffect::Report(std::span<double> channels) const {
  channels[0] = rpm();
  channels[1] = load_Nmm_;
  channels[2] = dt_s_ > 0 ? 1e-3 * run_.motor_mJ / dt_s_ : 0;
  channels[3] = stalled_ ? 1 : 0;
}

const EffectInfo& Spindle() {
  static const EffectInfo kEffect{
      .name = "spindle",
      .summary = "a motor that spins up and down, is slowed by the load and stalls; when stalled it does not cut",
      .source =
          "a linear torque-speed curve, like that of a DC motor; all values are assumptions for a dental or surgical "
          "handpiece (such motors have 3 N cm and over 60 W at 40000 rpm; geared down to 7500 rpm, 60 W on such a "
          "line correspond to 300 N mm at standstill)",
      .reads = "the set speed, the spindle's losses to teeth and flats, the motion",
      .writes = "the spindle speed of the tick",
      .state = "speed of the rotor, load of the last tick",
      .sleeps = "while switched off and at rest",
      .needs = {"tangential_force"},
      .hooks = kEffectBegin | kEffectSolved,
      .parameters = ListEffectParameters<SpindleParams>(),
      .channels = {{"rpm", "speed at the end of the tick; its sign is the direction, about +z"},
                   {"spindle_load_Nmm", "torque against its rotation"},
                   {"motor_W", "mechanical power of the motor, mean over the tick; negative: it brakes"},
                   {"stalled", "1: it is stopped although it is switched on"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        return std::make_unique<SpindleEffect>(ReadEffectParameters<SpindleParams>(values),
                                               TangentialForceEffect::In(*setup.plan), setup);
      }};
  return kEffect;
}

}  // namespace kerf
