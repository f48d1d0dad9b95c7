#include "cut/effects/tangential_force.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"
#include "cut/effects/plan.h"
#include "cut/effects/stroke_ways.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kLag_s = 0.004;
constexpr double kMin_N = 1e-9;
constexpr double kStalledSlip_rad_per_s = 100;
constexpr double kStalledSlip_mm_per_s = 1000;  // of an edge with a stroke
constexpr double kMinArm = 1e-9;                // mm; a tooth on the spindle's axis does not move

constexpr Range kRatioRange{0.6, 20};

struct TangentialForceParams {
  double ratio = 1.6;
};

template <typename V>
void Describe(TangentialForceParams& p, V&& visit) {
  visit("ratio", p.ratio, kRatioRange,
        "ratio of a tooth's thrust to its cutting force; not for a force law that states a cutting force itself");
}

/// Returns the sector of a point: an eighth of the turn about the spindle.
std::size_t FindSector(const Vec3& p_T) {
  return (p_T.x < 0 ? 1u : 0u) | (p_T.y < 0 ? 2u : 0u) | (std::abs(p_T.x) < std::abs(p_T.y) ? 4u : 0u);
}

}  // namespace

TangentialForceEffect::TangentialForceEffect(double ratio, const EffectSetup& setup)
    : by_law_(setup.law.HasCutting()),
      ratio_(by_law_ ? std::clamp(setup.law.least_thrust_per_cutting, kRatioRange.lower, kRatioRange.upper) : ratio),
      strokes_(GetDrive(setup.tool) != DriveMotion::kRotation),
      p_TC_(setup.p_TC_mm),
      is_coupled_(setup.faces != nullptr) {
  if (is_coupled_) CheckCuttingRatio(setup.law);
}

void CheckCuttingRatio(const ToothForce& law) {
  if (!law.HasCutting() || law.least_thrust_per_cutting >= kRatioRange.lower) return;
  throw Error(fmt::format(
      "tangential_force: the law's ratio of thrust to cutting force, or of their changes with the bite, is as small as "
      "{:.3g}; for a tool in a hand it must be at least {}",
      law.least_thrust_per_cutting, kRatioRange.lower));
}

const TangentialForceEffect& TangentialForceEffect::In(const EffectPlan& plan) {
  const Effect* effect = plan.Find("tangential_force");
  if (effect == nullptr) throw Error("the effect tangential_force is not enabled");
  return static_cast<const TangentialForceEffect&>(*effect);
}
TangentialForceEffect& TangentialForceEffect::In(EffectPlan& plan) {
  return const_cast<TangentialForceEffect&>(In(std::as_const(plan)));
}

void TangentialForceEffect::Engage(const EffectStep& step, StepProblem& problem) {
  if (strokes_ && !is_coupled_) {
    SetLever(step.rpm, step.stroke);
    Take(step.teeth, 1);
  }
  if (!is_loaded_) return;
  const std::array<Way, 2> ways = FindWays(step.rpm, step.stroke);
  if (ways[0].rad_per_s == 0 && ways[0].mm_per_s == 0) return;
  for (const Way& way : ways) {
    for (const Sector& sector : sectors_) {
      const double limit_N = way.share * fraction_ * sector.force_N;
      if (!(limit_N > kMin_N)) continue;
      FrictionPoint& point = problem.frictions.emplace_back();
      AddTo(point.row_a, 1 / sector.force_N, sector.row);
      point.slip_a_mm_per_s = way.rad_per_s * sector.arm_Nmm / sector.force_N + way.mm_per_s;
      point.limit_N = limit_N;
    }
  }
}

/// Returns the motions of the teeth. With the spindle stopped it has the direction of the motor's torque and is faster
/// than any hand, so that the force is that of the motor and does not act as friction.
std::array<TangentialForceEffect::Way, 2> TangentialForceEffect::FindWays(double rpm, const DriveStep* stroke) const {
  if (stroke == nullptr) {
    return {{{1, rpm != 0 ? rpm * std::numbers::pi / 30 : direction_ * kStalledSlip_rad_per_s, 0, 0}, {0, 0, 0, 0}}};
  }
  if (rpm == 0) {
    return {{{1, 0, direction_ * kStalledSlip_mm_per_s, direction_ * lever_mm_}, {0, 0, 0, 0}}};
  }
  const auto [forwards, backwards] = FindStrokeWays(*stroke, rpm, is_coupled_);
  return {{{forwards.share, 0, forwards.mm_per_s, lever_mm_}, {backwards.share, 0, backwards.mm_per_s, -lever_mm_}}};
}

void TangentialForceEffect::Solved(const EffectSolved& solved) {
  const bool turns = solved.rpm != 0;
  SetLever(solved.rpm, solved.stroke);
  for (ToothLoad& tooth : solved.teeth) tooth.tangential_N = CalcForce(tooth);
  if (is_loaded_) AddUp(solved);
  const bool was_loaded = is_loaded_;
  if (turns) {
    direction_ = solved.rpm > 0 ? 1 : -1;
    if (solved.stroke != nullptr) direction_ = solved.stroke->velocity_mm_per_s < 0 ? -1 : 1;
    if (!was_loaded && solved.teeth.empty()) return;
  } else if (motor_Nmm_ != 0 && !strokes_) {
    direction_ = motor_Nmm_ > 0 ? 1 : -1;
  }

  // A tool on a prescribed path does not yield to the force, so it needs no lag.
  const double lag = is_coupled_ ? 1 - std::exp(-solved.time_s / kLag_s) : 1;
  const bool lags = !strokes_ || !turns;
  const double fresh = is_coupled_ ? std::min(ratio_ * ratio_ / (1 + ratio_ * ratio_), lags ? lag : 1) : 1;
  if (turns) {
    Take(solved.teeth, fresh);
  } else {
    Fade(fresh);
    const StepProblem& problem = solved.problem;
    const std::size_t stopped_points = std::min(solved.edge.found_count(), problem.solids.size());
    for (std::size_t n = 0; n < stopped_points; ++n) {
      const SolidPoint& solid = problem.solids[n];
      const double depth_mm = solid.depth_mm + problem.tau_s * Dot(solid.row, solved.u);
      if (!(depth_mm > 0) || (strokes_ && !solved.edge.is_tooth(n))) continue;
      Add(solved.edge.point_T(static_cast<std::size_t>(solved.edge.found_point(n))),
          Vec3(solid.row[0], solid.row[1], solid.row[2]), fresh * solid.stiffness_N_per_mm * depth_mm / ratio_);
    }
    DropEmptySectors();
  }
  const double required_Nmm = CalcRequiredTorque();
  const double target = turns || std::abs(motor_Nmm_) >= required_Nmm ? 1 : std::abs(motor_Nmm_) / required_Nmm;
  fraction_ = was_loaded ? fraction_ + lag * (target - fraction_) : target;
}

double TangentialForceEffect::CalcForce(const ToothLoad& tooth) const {
  return by_law_ ? tooth.cutting_N : tooth.thrust_on_way_N / ratio_;
}

/// Sets the way per angle of the crank in a step in which the edge moves.
void TangentialForceEffect::SetLever(double rpm, const DriveStep* stroke) {
  if (rpm == 0 || stroke == nullptr) return;
  lever_mm_ = stroke->speed_mm_per_s / (std::abs(rpm) * std::numbers::pi / 30);
}

/// Replaces the fraction `fresh` of the sectors' forces by those of the teeth.
void TangentialForceEffect::Take(std::span<const ToothLoad> teeth, double fresh) {
  Fade(fresh);
  for (const ToothLoad& tooth : teeth) Add(tooth.p_T, tooth.e_T, fresh * CalcForce(tooth));
  DropEmptySectors();
}

void TangentialForceEffect::Fade(double fresh) {
  for (Sector& sector : sectors_) {
    sector.force_N *= 1 - fresh;
    sector.arm_Nmm *= 1 - fresh;
    for (double& r : sector.row) r *= 1 - fresh;
  }
}

void TangentialForceEffect::DropEmptySectors() {
  is_loaded_ = false;
  for (Sector& sector : sectors_) {
    if (sector.force_N > kMin_N) {
      is_loaded_ = true;
    } else {
      sector = {};
    }
  }
}

void TangentialForceEffect::Add(const Vec3& p_T, const Vec3& e_T, double force_N) {
  if (strokes_) {
    const double across = glm::length(glm::dvec2(e_T));
    if (!(force_N > 0) || !(across > 0)) return;
    sectors_[0].force_N += force_N;
    AddTo(sectors_[0].row, force_N, MakeRow(Vec3(-e_T.y, e_T.x, 0) / across, p_T - p_TC_));
    return;
  }
  const double arm_mm = glm::length(glm::dvec2(p_T));
  if (!(force_N > 0) || !(arm_mm > kMinArm)) return;
  Sector& sector = sectors_[FindSector(p_T)];
  sector.force_N += force_N;
  sector.arm_Nmm += force_N * arm_mm;
  AddTo(sector.row, force_N / arm_mm, MakeRow(Vec3(-p_T.y, p_T.x, 0), p_T - p_TC_));
}

double TangentialForceEffect::CalcRequiredTorque() const {
  double torque_Nmm = 0;
  for (const Sector& sector : sectors_) torque_Nmm += strokes_ ? lever_mm_ * sector.force_N : sector.arm_Nmm;
  return torque_Nmm;
}

/// Adds the results of the force in the solved step, computed as in CoupledSimulation::State::AddUp().
void TangentialForceEffect::AddUp(const EffectSolved& solved) {
  const double creep2 = solved.problem.creep_mm_per_s * solved.problem.creep_mm_per_s;
  const double rpm = strokes_ ? std::abs(solved.rpm) : solved.rpm;  // strokes have no direction of rotation
  const std::array<Way, 2> ways = FindWays(solved.rpm, solved.stroke);
  if (ways[0].rad_per_s == 0 && ways[0].mm_per_s == 0) return;
  for (const Way& way : ways) {
    for (const Sector& sector : sectors_) {
      const double force_N = way.share * fraction_ * sector.force_N;
      if (!(force_N > kMin_N)) continue;
      const double speed = (Dot(sector.row, solved.u) + way.rad_per_s * sector.arm_Nmm) / sector.force_N + way.mm_per_s;
      // Equals the share of the force, with the sign of the speed, unless it sticks.
      const double along = way.share * fraction_ * speed / std::sqrt(speed * speed + creep2);
      const double torque_Nmm = along * (strokes_ ? way.lever_mm * sector.force_N : sector.arm_Nmm);
      sums_.sum_N += solved.time_s * force_N;
      sums_.pull_T_N -= solved.time_s * along * Vec3(sector.row[0], sector.row[1], sector.row[2]);
      sums_.torque_Nmm += solved.time_s * std::copysign(1.0, strokes_ ? 1 : way.rad_per_s) * torque_Nmm;
      sums_.power_W += solved.time_s * 1e-3 * torque_Nmm * rpm * std::numbers::pi / 30;
    }
  }
  acted_ = true;
}

void TangentialForceEffect::End(EffectEnd& end) {
  if (end.rpm == 0 && !is_coupled_) Release();  // then no step is solved
  if (!acted_) return;
  const double inv = 1 / end.dt_s;
  figures_ = {inv * sums_.sum_N, inv * sums_.pull_T_N, inv * sums_.torque_Nmm, inv * sums_.power_W};
  acted_ = sums_.sum_N > 0;
  sums_ = {};
}

void TangentialForceEffect::Release() {
  if (!is_loaded_) return;
  is_loaded_ = false;
  sectors_ = {};
}

void TangentialForceEffect::Report(std::span<double> channels) const {
  channels[0] = figures_.sum_N;
  channels[1] = glm::length(figures_.pull_T_N);
  channels[2] = figures_.torque_Nmm;
  channels[3] = figures_.power_W;
}

const EffectInfo& TangentialForce() {
  static const EffectInfo kEffect{
      .name = "tangential_force",
      .summary =
          "cutting force along the teeth's motion: the pull of a climb cut, and the torque that loads the spindle",
      .source =
          "the law's cutting force if it states one; otherwise a ratio thrust / cutting force of 1.4 to 1.8, of a "
          "sagittal saw's tooth in bovine femur (docs/physics.md); that "
          "it is the same at all bites is an assumption (James et al. 2013: only the thrust grows with the bite)",
      .reads = "thrust and cutting force of the teeth, spindle speed, motion",
      .writes = "force and torque on the tool, the teeth's tangential force",
      .state = "force and position of the teeth, by eighths of a turn",
      .sleeps = "while no tooth is engaged",
      .hooks = kEffectEngage | kEffectSolved | kEffectEnd,
      .parameters = ListEffectParameters<TangentialForceParams>(),
      .channels = {{"tangential_sum_N", "sum of the teeth's tangential forces, mean over the tick"},
                   {"tangential_pull_N", "resultant of these forces on the tool"},
                   {"cutting_torque_Nmm", "torque of these forces on the spindle, against its rotation"},
                   {"cutting_W", "power that the spindle delivers to cut"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        const auto params = ReadEffectParameters<TangentialForceParams>(values);
        return std::make_unique<TangentialForceEffect>(params.ratio, setup);
      }};
  return kEffect;
}

}  // namespace kerf
