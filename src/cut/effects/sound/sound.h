// sound: the sound of a motor and its cut. The tick only records the inputs of the tone; Tone computes the samples.
#pragma once

#include <span>

#include "cut/effects/effect.h"
#include "cut/effects/sound/tone.h"

namespace kerf {

class TangentialForceEffect;

struct SoundParams {
  ToneParams tone;
  double passing_share = 0.4;  // force amplitude at the tooth-passing frequency / mean force of a tooth
  double cutting_share = 0.625;
};

/// Records the inputs of the tone in each tick.
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
  const TangentialForceEffect* cutting_;  // source of the power; null: it is estimated from the thrust
  double spindle_Hz_ = 0;
  double load_W_ = 0;
  double passing_N_ = 0;
};

/// Reads the inputs of the tone from the channels of a plan's effects after each tick: those of the sound effect and,
/// if tooth_vibration is enabled, its lines instead of the sound effect's estimate.
class ToneReader {
 public:
  ToneReader() = default;
  explicit ToneReader(const EffectPlan& plan);

  /// Returns true if the plan contains the sound effect.
  bool any() const { return sound_ >= 0; }
  const ToneParams& tone() const { return tone_; }
  int teeth() const { return teeth_; }
  /// `channels`: those of all effects. Tick-safe.
  ToneFrame Read(double dt_s, std::span<const double> channels) const;

 private:
  ToneParams tone_;
  int teeth_ = 0;
  int sound_ = -1;  // its first channel
  int runout_ = -1, set_ = -1, passing_ = -1;
};

}  // namespace kerf
