// The effect plan compiled out: the interface of effects/plan.h that src/cut/path_sim and src/cut/hand_sim use, without
// any content. tools/off_is_free compares the tick built with this header to the regular tick. KERF_PLAN_WORK adds that
// amount of work to each call, so that the comparison itself can be tested.
#pragma once

#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cut/effects/effect.h"
#include "kerf/observe.h"

#ifndef KERF_PLAN_WORK
#define KERF_PLAN_WORK 0
#endif

namespace kerf {

class EffectPlan {
 public:
  EffectPlan(const EffectChoices&, const EffectSetup&) {
    if (KERF_PLAN_WORK > 0) ::operator delete(::operator new(4096));
  }

  void Begin(EffectBegin&) { Work(); }
  bool Holds(const EffectFlight&) {
    Work();
    return wanted_;
  }
  void Engage(const EffectStep&, StepProblem&) { Work(); }
  bool wants_solved() const { return wanted_; }
  bool wants_steps() const { return wanted_; }
  std::span<ToothLoad> FindTeeth(const StepProblem&, const Edge&, const Twist&) { return {}; }
  void Solved(EffectSolved&) {}
  void End(EffectEnd&) { Work(); }
  void Release() { Work(); }
  void Reset() { Work(); }
  void BoneRestored() {}
  const Effect* Find(std::string_view) const { return nullptr; }
  std::vector<std::string> ListChannels() const { return {}; }
  void Report(std::span<double>) const {}
  EffectCapacity capacity() const { return {}; }
  std::size_t CalcMemoryBytes() const { return 0; }

 private:
  // Always false, which the compiler cannot deduce: code that depends on it is kept, so that the rest of the tick is
  // compiled as with a plan.
  bool wanted_ = false;

  static void Work() {
    for (int i = 0; i < KERF_PLAN_WORK; ++i) asm volatile("");
  }
};

class EffectsStage {
 public:
  EffectsStage(TickObserver*, const EffectPlan&, TickStage) {}
  ~EffectsStage() {}
};

}  // namespace kerf
