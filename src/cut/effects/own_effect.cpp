#include "cut/effects/own_effect.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "base/core/heap_guard.h"
#include "cut/contact/broken_rule.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Passes the calls on, in the world frame, and checks in guarded programs that they use no heap memory. Throws
/// BrokenRule if they throw or give a number that is not finite.
class OwnEffectCaller final : public Effect {
 public:
  OwnEffectCaller(const EffectInfo& info, std::unique_ptr<OwnEffect> own, const Vec3& p_WF_mm)
      : name_(info.name), pushes_((info.hooks & kEffectPush) != 0), own_(std::move(own)), p_WF_mm_(p_WF_mm) {}

  void Begin(EffectBegin& begin) override {
    Call([&] { own_->Begin(begin); });
    if (std::isfinite(begin.rpm)) return;
    const HeapGuardPause pause;
    throw BrokenRule(fmt::format("the effect {} sets a speed of {:g} rpm; it must be finite", name_, begin.rpm));
  }
  void Solved(const EffectSolved& solved) override {
    Call([&] {
      own_->Solved({.X_WT_from = ToWorld(solved.X_FT),
                    .X_WT_to = ToWorld(solved.X_FT_next),
                    .time_s = solved.time_s,
                    .rpm = solved.rpm,
                    .teeth = solved.teeth});
    });
  }
  void End(EffectEnd& end) override {
    OwnEffectEnd own{.dt_s = end.dt_s,
                     .rpm = end.rpm,
                     .X_WT = ToWorld(end.X_FT),
                     .engaged_teeth = end.engaged_teeth,
                     .thrust_sum_N = end.thrust_sum_N,
                     .removed_mm3 = end.removed_mm3};
    Call([&] { own_->End(own); });
    if (!pushes_) return;
    const Vec3& f = own.f_extra_W_N;
    if (!std::isfinite(f.x + f.y + f.z)) {
      const HeapGuardPause pause;
      throw BrokenRule(
          fmt::format("the effect {} pushes the hand with a force of ({:g}, {:g}, {:g}) N; it must be finite", name_,
                      f.x, f.y, f.z));
    }
    end.f_extra_W_N += f;
  }
  void Reset() override {
    const HeapGuard guard;
    own_->Reset();
  }
  void Report(std::span<double> channels) const override {
    const HeapGuard guard;
    own_->Report(channels);
  }
  std::size_t CalcMemoryBytes() const override { return sizeof(*this) + own_->CalcMemoryBytes(); }

 private:
  Pose ToWorld(const Pose& X_FT) const { return {X_FT.R_AB, X_FT.p_AB + p_WF_mm_}; }
  template <typename Function>
  void Call(Function&& function) {
    CallOwn("effect", name_, [&] {
      const HeapGuard guard;
      function();
    });
  }

  const char* name_;
  bool pushes_;
  std::unique_ptr<OwnEffect> own_;
  Vec3 p_WF_mm_;
};

}  // namespace

std::unique_ptr<Effect> MakeOwnEffect(const EffectInfo& info, std::span<const EffectValue> values,
                                      const EffectSetup& setup) {
  std::unique_ptr<OwnEffect> own = info.make_own(
      values, {.bone = setup.bone, .tool = setup.tool, .in_hand = setup.faces != nullptr, .files = setup.files});
  if (own == nullptr) throw Error(fmt::format("the effect {} was not made", info.name));
  return std::make_unique<OwnEffectCaller>(info, std::move(own), setup.p_WF_mm);
}

}  // namespace kerf
