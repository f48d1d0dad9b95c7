#include "experiment/stability/scenario_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "cut/tool/looks.h"
#include "cut/tool/shape.h"
#include "experiment/stability/measures.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kMinWindow_s = 0.25;  // minimum window in which noise is judged
constexpr double kMinOfAll_s = 0.1;    // the same for a tool that has cut through; two periods of 20 Hz
constexpr double kPushOn_s = 0.3;
constexpr double kSettle_s = 0.05;          // settling time after bone is first cut
constexpr double kSearchInterval_s = 0.01;  // interval of the search for bone ahead of the tool
constexpr double kAhead_mm = 2;             // distance of that search; the hops of a tool that chatters are shorter
constexpr double kOnLine = 0.5;  // maximum distance from the line of the feed, as a fraction of the tool's reach

}  // namespace

std::vector<Vec3> SampleEdge(const Tool& tool) {
  std::vector<Vec3> points;
  for (const EdgePoint& point : MakeToolShape(tool, {}).edge) points.push_back(point.p_T);
  return points;
}

double CalcBuried(const Bone& bone, const Tool& tool, const Pose& X_WT) {
  double deepest = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : SampleEdge(tool)) deepest = std::max(deepest, -bone.SignedDistance(X_WT.Point(p)));
  return deepest;
}

Pose BackOff(const StabilitySubject& subject, double max_mm) {
  Pose X = subject.X_WT_start;
  const double step_mm = 0.5 * subject.bone.voxel_mm();
  for (double back_mm = 0; back_mm < max_mm; back_mm += step_mm) {
    Pose next = X;
    next.p_AB -= step_mm * subject.into_W;
    if (CalcBuried(subject.bone, subject.setup.coupled.tool, next) > 0) break;
    X = next;
  }
  return X;
}

double CalcThickness(const StabilitySubject& subject, double max_mm) {
  // This is the thickness along the path of the edge's leading point.
  const Pose& X_WT = subject.X_WT_start;
  const Vec3 front = X_WT.Point(FindForemost(subject.setup.coupled.tool, X_WT.InverseVector(subject.into_W)));
  const double step_mm = 0.25 * subject.bone.voxel_mm();
  double inside_mm = 0;
  double depth_mm = 0;
  for (; depth_mm < max_mm + 3; depth_mm += step_mm) {
    const bool inside = subject.bone.SignedDistance(front + depth_mm * subject.into_W) < 0;
    if (inside) inside_mm += step_mm;
    if (!inside && inside_mm > 0) return inside_mm;
    if (inside_mm > max_mm) break;
  }
  return std::numeric_limits<double>::infinity();
}

ScenarioRun::ScenarioRun(const StabilitySubject& subject, const Scenario& scenario)
    : ScenarioRun(subject, scenario, subject.bone, subject.X_WT_start) {}

ScenarioRun::ScenarioRun(const StabilitySubject& subject, const Scenario& scenario, const HeldTool& held)
    : ScenarioRun(subject, scenario, held.bone, held.X_WT) {}

ScenarioRun::ScenarioRun(const StabilitySubject& subject, const Scenario& scenario, Bone bone, const Pose& X_WT)
    : subject_(subject),
      X_WT_start_(X_WT),
      scale_(ForceMap(subject.setup.profile, subject.setup.force_map).force_scale()),
      slew_N_per_s_(ForceMap(subject.setup.profile, subject.setup.force_map).slew_N_per_s()),
      loop_(bone, subject.setup, X_WT),
      rpm_(subject.rpm),
      initial_bone_(std::move(bone)) {
  result_.name = scenario.name;
  result_.what = scenario.what;
  for (const EdgePoint& point : MakeToolShape(subject.setup.coupled.tool, {}).edge) {
    if (glm::dot(X_WT.Vector(point.e_T), subject.into_W) > 0) leading_T_.push_back(point.p_T);
  }
}

double ScenarioRun::CalcPush_N(double simulated_N) const {
  const DeviceProfile& profile = subject_.setup.profile;
  double push_N = scale_ * std::min(simulated_N, 0.8 * subject_.setup.coupled.coupling.max_force_N);
  push_N = std::min(push_N, 0.8 * subject_.setup.force_map.knee * profile.peak_force_N);
  if (profile.continuous_force_N > 0) push_N = std::min(push_N, 0.8 * profile.continuous_force_N);
  return push_N + profile.friction_N;
}

Vec3 ScenarioRun::FindCutPush_N(double simulated_N, const HandModel& hand) {
  double push_N = CalcPush_N(simulated_N);
  if (const std::optional<double> feed_N = FindFeedForce_N(subject_)) {
    const DeviceProfile& profile = subject_.setup.profile;
    // The hand's target position yields, so its spring is stretched by what the handle moves in that time.
    const double drag_Ns_per_mm =
        profile.own_damping_Ns_per_mm + hand.damping_Ns_per_mm + kYield_s * hand.stiffness_N_per_mm;
    const double limit_N = scale_ * *feed_N + profile.friction_N + drag_Ns_per_mm * kFastFeed_mm_per_s;
    if (limit_N < push_N) {
      Say(fmt::format(" The hand pushes the device with {:.2g} N, for a feed of {} mm/s.", limit_N,
                      kFastFeed_mm_per_s));
      push_N = limit_N;
    }
  }
  return push_N * subject_.into_W;
}

double ScenarioRun::CalcGrain(double force_N) const {
  if (!subject_.setup.quantise) return 0;
  const double step_N =
      scale_ * subject_.setup.coupled.coupling.stiffness_N_per_mm * subject_.setup.profile.resolution_mm;
  return step_N / CalcJustNoticeable_N(force_N);
}

void ScenarioRun::Lean(const Vec3& push_W_N) {
  IntentionStep push;
  push.seconds = 1e5;
  push.X_WH = X_WT_start_;
  push.push_W_N = push_W_N;
  push.yield_s = kYield_s;
  push.push_on_s = kPushOn_s;
  loop_.device().SetScript(IntentionScript(X_WT_start_, {push}));
}

void ScenarioRun::Release() {
  was_released_ = true;
  loop_.device().SetHand(FindHandModel("H0"));
  loop_.device().SetIntention({.X_WH = X_WT_start_});
}

void ScenarioRun::Grip(const HandModel& hand) {
  loop_.device().SetHand(hand);
  Pose X = X_WT_start_;
  X.p_AB = tick_.p_WC_mm - X.Vector(subject_.setup.coupled.coupling.p_TC_mm);
  loop_.device().SetIntention({.X_WH = X});
}

const ClosedLoopTick& ScenarioRun::Step() {
  if (subject_.stop && subject_.stop()) throw Error("the scenario was stopped");
  return Take(loop_.Step(rpm_));
}

const ClosedLoopTick& ScenarioRun::Take(const ClosedLoopTick& tick) {
  tick_ = tick;
  watch_.Add(tick_);
  const Vec3& f = tick_.f_device_N;
  f_N_.push_back(f);
  p_mm_.push_back(tick_.p_WC_mm);
  result_.time_s.push_back(tick_.time_s);
  result_.force_N.push_back(glm::length(f));
  CheckCutThrough();
  return tick_;
}

void ScenarioRun::CheckCutThrough() {
  if (!has_cut_ && tick_.out.coupled.removed_mm3 > 0) {
    has_cut_ = true;
    first_cut_ = now();
  }
  if (!has_cut_ || is_through() || static_cast<double>(now() - last_search_) * T() < kSearchInterval_s) return;
  last_search_ = now();
  const Vec3 moved = tick_.out.coupled.X_WT.p_AB - X_WT_start_.p_AB;
  const double along_mm = glm::dot(moved, subject_.into_W);
  const Vec3 across = moved - along_mm * subject_.into_W;
  const double reach_mm = CalcReach(subject_.setup.coupled.tool);
  left_line_ = left_line_ || glm::length(across) > kOnLine * reach_mm;
  // A released handle is pushed off the bone and comes back.
  const bool is_back = was_released_ && along_mm < furthest_mm_ - 0.5 * kAhead_mm;
  furthest_mm_ = std::max(furthest_mm_, along_mm);
  if (left_line_ || is_back || IsBoneAhead()) return;
  result_.cut_through_s = tick_.time_s;
}

std::size_t ScenarioRun::FirstSteady() const {
  return first_cut_ + static_cast<std::size_t>(std::lround(kSettle_s / T()));
}

bool ScenarioRun::IsBoneAhead() const {
  const double step_mm = 0.5 * initial_bone_.voxel_mm();
  for (const Vec3& p_T : leading_T_) {
    const Vec3 p_W = tick_.out.coupled.X_WT.Point(p_T);
    for (double ahead_mm = 0; ahead_mm < kAhead_mm; ahead_mm += step_mm) {
      if (initial_bone_.SignedDistance(p_W + ahead_mm * subject_.into_W) < 0) return true;
    }
  }
  return false;
}

void ScenarioRun::Run(double seconds) {
  const int ticks = static_cast<int>(std::lround(seconds / T()));
  for (int i = 0; i < ticks; ++i) Step();
}

std::size_t ScenarioRun::RunInBone(double seconds) {
  const int ticks = static_cast<int>(std::lround(seconds / T()));
  const auto tenth = static_cast<std::size_t>(std::lround(0.1 / T()));
  const std::size_t start = now();
  if (is_through()) return start;
  std::size_t idle = 0;
  for (int i = 0; i < ticks; ++i) {
    Step();
    if (is_through()) return std::max(start, now() - std::min(now(), tenth));
    idle = f_N_.back() == Vec3(0) ? idle + 1 : 0;
    if (idle > tenth) return std::max(start, now() - std::min(now(), 2 * tenth));
  }
  return now();
}

void ScenarioRun::AwaitRamp() {
  Run(subject_.setup.force_map.ramp_in_s + 2 * T());
}

std::span<const Vec3> ScenarioRun::forces_N(std::size_t from, std::size_t to) const {
  return std::span(f_N_).subspan(from, std::min(to, f_N_.size()) - from);
}

std::span<const Vec3> ScenarioRun::positions_mm(std::size_t from, std::size_t to) const {
  return std::span(p_mm_).subspan(from, std::min(to, p_mm_.size()) - from);
}

std::vector<double> ScenarioRun::ForcesAlong_N(const Vec3& direction_W, std::size_t from, std::size_t to) const {
  std::vector<double> along;
  for (const Vec3& f : forces_N(from, to)) along.push_back(glm::dot(f, direction_W));
  return along;
}

double ScenarioRun::MeanForce_N(std::size_t from, std::size_t to) const {
  const auto forces = forces_N(from, to);
  Vec3 sum(0);
  for (const Vec3& f : forces) sum += f;
  return forces.empty() ? 0 : glm::length(sum) / static_cast<double>(forces.size());
}

void ScenarioRun::AtMost(const std::string& name, const std::string& unit, double value, double bound) {
  result_.figures.push_back({name, unit, value, bound, true});
}

void ScenarioRun::AtLeast(const std::string& name, const std::string& unit, double value, double bound) {
  result_.figures.push_back({name, unit, value, bound, false});
}

void ScenarioRun::AddNoise(std::size_t from, std::size_t to, double fraction) {
  const std::size_t end = std::min(to, now());
  const double min_s = is_through() ? kMinOfAll_s : kMinWindow_s;
  if (end < from + static_cast<std::size_t>(std::lround(min_s / T()))) {
    LeaveUnjudged("The tool cut through the bone or left it too soon for the noise to be judged.");
    return;
  }
  AddNoiseFigure(CalcNoise(forces_N(from, to), T()), MeanForce_N(from, to), fraction);
}

void ScenarioRun::AddCutNoise(std::size_t from, std::size_t to) {
  const std::size_t end = std::min(to, now());
  const auto part = static_cast<std::size_t>(std::lround(kMinOfAll_s / T()));
  const std::size_t start = std::min(FirstSteady(), end);
  const bool too_short = end < from + static_cast<std::size_t>(std::lround(kMinWindow_s / T()));
  if (!is_through() || !too_short || end < start + part) return AddNoise(from, to);
  std::vector<std::pair<double, std::size_t>> noise_N;
  for (std::size_t at = start; at + part <= end; at += part) {
    noise_N.emplace_back(CalcNoise(forces_N(at, at + part), T()), at);
  }
  const auto middle = noise_N.begin() + static_cast<std::ptrdiff_t>(noise_N.size() / 2);
  std::nth_element(noise_N.begin(), middle, noise_N.end());
  AddNoiseFigure(middle->first, MeanForce_N(middle->second, middle->second + part), kNoiseFraction);
}

void ScenarioRun::AddNoiseFigure(double noise_N, double mean_N, double fraction) {
  AtMost("noise above 20 Hz", "mN", 1000 * noise_N, std::max(20.0, 1000 * fraction * mean_N));
}

void ScenarioRun::AddEnergy() {
  const PortEnergy& e = tick_.energy;
  AtLeast("energy absorbed by the motors, minimum", "mJ", e.lowest_mJ,
          -(e.held_mJ + std::max(1e-3, 1e-3 * e.exchanged_mJ)));
}

ScenarioResult ScenarioRun::Finish() {
  const DeviceProfile& profile = subject_.setup.profile;
  const auto add_clamped = [this](const std::string& name, const std::string& unit, double value, double bound) {
    AtMost(name, unit, value, bound);
    result_.figures.back().clamped = true;
  };
  AtMost("values that are not finite", "", watch_.not_finite(), 0);
  add_clamped("largest force", "N", watch_.largest_N(), profile.peak_force_N);
  add_clamped("largest force step in a tick", "N", watch_.largest_step_N(), slew_N_per_s_ * T() * (1 + 1e-9));
  AtMost("force in air", "N", watch_.largest_in_air_N(), 0);
  if (watch_.largest_torque_Nmm() > 0) {
    add_clamped("largest torque", "N mm", watch_.largest_torque_Nmm(), profile.peak_torque_Nmm);
  }
  return result_;
}

bool ScenarioRun::IsOff(double seconds) const {
  const auto count = static_cast<std::size_t>(std::lround(seconds / T()));
  if (count == 0 || now() < count) return false;
  const auto last = forces_N(now() - count);
  return std::all_of(last.begin(), last.end(), [](const Vec3& f) { return f == Vec3(0); });
}

ScenarioResult ScenarioRun::NotJudged(const Scenario& scenario, const std::string& why) {
  ScenarioResult result;
  result.name = scenario.name;
  result.what = scenario.what;
  result.unjudged = why;
  return result;
}

ScenarioResult ScenarioRun::Skip(const Scenario& scenario, const std::string& why) {
  ScenarioResult result;
  result.name = scenario.name;
  result.what = std::string(scenario.what) + " Skipped: " + why;
  result.skipped = true;
  return result;
}

}  // namespace kerf
