// The effects of a scene, sorted once into lists: at each point of a tick only the effects that have work there are
// called.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cut/effects/effect.h"
#include "kerf/observe.h"

namespace kerf {

/// Effects of one simulation, and the calls of their hooks in a tick.
class EffectPlan {
 public:
  /// Throws Error like CheckEffects(). Omits the effects that need a tool coupled to a handle if there is none
  /// (setup.faces is null), and lists them in left_out().
  EffectPlan(const EffectChoices& choices, const EffectSetup& setup);

  // ---- in the tick
  void Begin(EffectBegin& begin) {
    ForEach(begin_, [&](Effect& effect) { effect.Begin(begin); });
  }
  bool Holds(const EffectFlight& flight) {
    bool holds = false;
    ForEach(holds_, [&](Effect& effect) { holds = effect.Holds(flight) || holds; });
    return holds;
  }
  void Engage(const EffectStep& step, StepProblem& problem) {
    ForEach(engage_, [&](Effect& effect) { effect.Engage(step, problem); });
  }
  bool wants_solved() const { return !solved_.empty(); }
  /// Returns the teeth of a step whose motion is known, if an effect reads them. Valid until the next call or Solved().
  std::span<ToothLoad> FindTeeth(const StepProblem& problem, const Edge& edge, const Twist& u);
  bool wants_steps() const { return !engage_.empty() || wants_solved(); }
  /// Fills `solved.teeth` if an effect reads it.
  void Solved(EffectSolved& solved);
  void End(EffectEnd& end) {
    ForEach(end_, [&](Effect& effect) { effect.End(end); });
  }
  void Release() {
    for (const Entry& entry : entries_) entry.effect->Release();
  }
  void Reset() {
    for (const Entry& entry : entries_) entry.effect->Reset();
  }

  void BoneRestored() {
    for (const Entry& entry : entries_) entry.effect->BoneRestored();
  }

  // ---- between ticks
  /// Sets the observer that is notified of the work of each effect; null: none.
  void set_observer(TickObserver* observer) { observer_ = observer; }
  struct Entry {
    const EffectInfo* info;
    std::unique_ptr<Effect> effect;
    std::size_t first_channel;
  };
  const std::vector<Entry>& entries() const { return entries_; }
  /// Returns null if the effect is not in the plan.
  const Effect* Find(std::string_view name) const;
  Effect* Find(std::string_view name);
  std::size_t channel_count() const { return channel_count_; }
  /// Returns the name of each channel with that of its effect in front: "heat.peak_C".
  std::vector<std::string> ListChannels() const;
  /// Writes the channels of all effects, one after the other. Tick-safe.
  void Report(std::span<double> channels) const;
  const std::vector<const EffectInfo*>& left_out() const { return left_out_; }
  EffectCapacity capacity() const;
  std::size_t CalcMemoryBytes() const;

 private:
  struct Called {
    Effect* effect;
    std::size_t place;  // index in entries_
  };
  template <typename Call>
  void ForEach(const std::vector<Called>& list, Call&& call) {
    for (const Called& called : list) {
      if (observer_ != nullptr) observer_->EnterEffect(called.place);
      call(*called.effect);
      if (observer_ != nullptr) observer_->LeaveEffect();
    }
  }
  std::vector<Entry> entries_;
  std::vector<const EffectInfo*> left_out_;
  std::vector<Called> begin_, holds_, engage_, solved_, end_;
  TickObserver* observer_ = nullptr;
  std::size_t channel_count_ = 0;
  const ToolShape* shape_;
  bool reads_teeth_ = false;
  std::vector<ToothLoad> teeth_;  // as many as the edge has points; FindTeeth() fills the first ones
};

/// While it exists, the tick is in the stage kEffects; afterwards it is in `after` again. Does nothing without an
/// observer or without effects.
class EffectsStage {
 public:
  EffectsStage(TickObserver* observer, const EffectPlan& plan, TickStage after)
      : observer_(observer != nullptr && !plan.entries().empty() ? observer : nullptr), after_(after) {
    if (observer_ != nullptr) observer_->Enter(TickStage::kEffects);
  }
  ~EffectsStage() {
    if (observer_ != nullptr) observer_->Enter(after_);
  }
  EffectsStage(const EffectsStage&) = delete;
  EffectsStage& operator=(const EffectsStage&) = delete;

 private:
  TickObserver* observer_;
  TickStage after_;
};

}  // namespace kerf
