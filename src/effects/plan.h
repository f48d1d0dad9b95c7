// The effects of a scene, put in order once: the tick walks lists in which only those stand that have something to do
// there.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "effects/effect.h"

namespace kerf {

class EffectPlan {
 public:
  /// Throws Error as CheckEffects(). Leaves out what needs a hand where there is none (setup.faces is null); names it
  /// in left_out().
  EffectPlan(const EffectChoices& choices, const EffectSetup& setup);

  // ---- in the tick
  void Begin(EffectBegin& begin) {
    for (Effect* effect : begin_) effect->Begin(begin);
  }
  bool Holds(const EffectFlight& flight) {
    bool holds = false;
    for (Effect* effect : holds_) holds = effect->Holds(flight) || holds;
    return holds;
  }
  void Engage(const EffectStep& step, StepProblem& problem) {
    for (Effect* effect : engage_) effect->Engage(step, problem);
  }
  bool wants_solved() const { return !solved_.empty(); }
  bool wants_steps() const { return !engage_.empty() || wants_solved(); }
  /// Fills `solved.teeth` when one of them reads it.
  void Solved(EffectSolved& solved);
  void End(EffectEnd& end) {
    for (Effect* effect : end_) effect->End(end);
  }
  void Release() {
    for (const Entry& entry : entries_) entry.effect->Release();
  }
  void Reset() {
    for (const Entry& entry : entries_) entry.effect->Reset();
  }

  // ---- any time
  struct Entry {
    const EffectInfo* info;
    std::unique_ptr<Effect> effect;
    std::size_t first_channel;
  };
  const std::vector<Entry>& entries() const { return entries_; }
  /// Null when it is not in the plan.
  const Effect* Find(std::string_view name) const;
  Effect* Find(std::string_view name);
  std::size_t channel_count() const { return channel_count_; }
  /// Of all effects, one after the other. Tick-safe.
  void Report(std::span<double> channels) const;
  const std::vector<const EffectInfo*>& left_out() const { return left_out_; }
  EffectCapacity capacity() const;
  std::size_t CalcMemoryBytes() const;

 private:
  void FindTeeth(EffectSolved& solved);

  std::vector<Entry> entries_;
  std::vector<const EffectInfo*> left_out_;
  std::vector<Effect*> begin_, holds_, engage_, solved_, end_;
  std::size_t channel_count_ = 0;
  const ToolShape* shape_;
  bool reads_teeth_ = false;
  std::vector<ToothLoad> teeth_;
};

}  // namespace kerf
