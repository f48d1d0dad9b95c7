#include "experiment/stability/margins.h"

#include "device/devices/profiles.h"
#include "experiment/stability/held_tool.h"
#include "loop/haptics/coupling_limits.h"

namespace kerf {

const char* ToString(Behaviour behaviour) {
  switch (behaviour) {
    case Behaviour::kStable:
      return "stable";
    case Behaviour::kLimitCycle:
      return "limit cycle";
    case Behaviour::kUnstable:
      return "unstable";
    case Behaviour::kNotHeld:
      return "not held";
  }
  return "";
}

const char* ToString(Judgement judgement) {
  switch (judgement) {
    case Judgement::kHolds:
      return "yes";
    case Judgement::kBroken:
      return "no";
    case Judgement::kNotJudged:
      return "not judged";
    case Judgement::kNotAsked:
      return "not asked";
  }
  return "";
}

Judgement Margins::Judge(double min_gain, int min_delay_ticks) const {
  if (!unjudged.empty()) return Judgement::kNotJudged;
  const bool gain_enough = gain >= min_gain;
  const bool delay_enough = delay_ticks >= min_delay_ticks;
  if (gain_enough && delay_enough) return Judgement::kHolds;
  const bool broken = (!gain_enough && !gain_beyond) || (!delay_enough && !delay_beyond);
  return broken ? Judgement::kBroken : Judgement::kNotJudged;
}

const char* ToString(HeldState state) {
  switch (state) {
    case HeldState::kStoppedOnBone:
      return "stopped on bone";
    case HeldState::kCutting:
      return "cutting";
    case HeldState::kInKerf:
      return "in the kerf";
  }
  return "";
}

ClosedLoopSetup FitSetup(ClosedLoopSetup setup, const DeviceProfile& profile, const HandModel& hand,
                         const HandModel& fitted_to) {
  setup.profile = profile;
  setup.hand = hand;
  const ForceMap map(profile, setup.force_map);
  setup.coupled.coupling = FitCoupling(profile, fitted_to, setup.coupled.coupling, map.force_scale(),
                                       map.torque_scale(), setup.period_s, setup.delay_ticks)
                               .coupling;
  return setup;
}

std::vector<ProfileMargins> CalcProfileMargins(const StabilitySubject& subject,
                                               const std::vector<DeviceProfile>& profiles,
                                               const std::function<void(double)>& progress,
                                               const std::atomic<bool>* stop) {
  const auto ended = [stop] { return stop != nullptr && stop->load(); };
  std::vector<HeldTool> held;
  for (const HeldState state : kHeldStates) {
    if (!ended()) held.push_back(HoldTool(subject, state));
  }
  std::vector<ProfileMargins> rows;
  const std::size_t all = profiles.size() * (HandModels().size() + 1);
  const auto add = [&](const DeviceProfile& profile, const HandModel& hand, const HandModel& fitted_to) {
    const ClosedLoopSetup setup = FitSetup(subject.setup, profile, hand, fitted_to);
    ProfileMargins row;
    row.profile = profile.name;
    row.hand = hand.name;
    row.fitted_to = fitted_to.name;
    row.coupling = setup.coupled.coupling;
    row.force_scale = ForceMap(profile, setup.force_map).force_scale();
    for (std::size_t i = 0; i < held.size() && !ended(); ++i) row.margins[i] = FindHeldMargins(held[i], setup, true);
    if (ended()) return;
    rows.push_back(row);
    if (progress) progress(static_cast<double>(rows.size()) / static_cast<double>(all));
  };
  for (const DeviceProfile& profile : profiles) {
    for (const HandModel& hand : HandModels()) add(profile, hand, hand);
    add(profile, FindHandModel("H0"), FindHandModel("H3"));
  }
  return rows;
}

}  // namespace kerf
