// sound: what a motor and its cut sound like. The tick only notes what the tone goes by; Tone makes the samples.
#pragma once

#include <span>

#include "cut/effects/effect.h"
#include "cut/effects/sound/tone.h"

namespace kerf {

class TangentialForceEffect;

struct SoundParams {
  ToneParams tone;
  double passing_share = 0.4;  // amplitude at the teeth's frequency, of the mean force of a tooth
  double cutting_share = 0.625;
};

class SoundEffect final : public Effect {
 public:
  SoundEffect(const SoundParams& params, const EffectSetup& setup);

  void End(EffectEnd& end) override;
  void Reset() override { spindle_Hz_ = load_W_ = passing_N_ = 0; }
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override { return sizeof(*this); }

  const ToneParams& tone() const { return params_.tone; }
  int teeth() const { return teeth_; }

 private:
  SoundParams params_;
  int teeth_;
  double radius_mm_;
  const TangentialForceEffect* cutting_;  // whose power it is; null: it is estimated from the thrust
  double spindle_Hz_ = 0;
  double load_W_ = 0;
  double passing_N_ = 0;
};

/// Finds what the tone goes by among the figures that a plan's effects give after each tick: the sound's own, and the
/// teeth's lines of tooth_vibration when that is on as well, in place of the sound's estimate.
class ToneReader {
 public:
  ToneReader() = default;
  explicit ToneReader(const EffectPlan& plan);

  /// Whether the plan has the sound.
  bool any() const { return sound_ >= 0; }
  const ToneParams& tone() const { return tone_; }
  int teeth() const { return teeth_; }
  /// `channels`: of all effects. Tick-safe.
  ToneFrame Read(double dt_s, std::span<const double> channels) const;

 private:
  ToneParams tone_;
  int teeth_ = 0;
  int sound_ = -1;  // first channel
  int runout_ = -1, set_ = -1, passing_ = -1;
};

}  // namespace kerf
