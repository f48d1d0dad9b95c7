// sound: the sound of a motor and its cut. The tick only records the inputs of the tone; Tone computes the samples.
#pragma once

#include <span>

#include "cut/effects/effect.h"
#include "cut/effects/sound/tone.h"
#include "kerf/describe.h"

namespace kerf {

class TangentialForceEffect;

struct SoundParams {
  ToneParams tone;
  double passing_share = 0.4;
  double cutting_share = 0.625;
};

template <typename V>
void Describe(SoundParams& p, V&& visit) {
  ToneParams& tone = p.tone;
  visit("rate_Hz", tone.rate_Hz, Range{8000, 192000}, "samples per second, a whole number");
  visit("motor_order", tone.motor_order, Range{1, 200},
        "frequency of the motor's whine (gear or poles), as a multiple of the spindle's; an assumption");
  visit("motor_level", tone.motor_level, Range{0, 0.3}, "maximum amplitude of the motor, as a fraction of full scale");
  visit("teeth_level", tone.teeth_level, Range{0, 0.3},
        "maximum amplitude of the passing teeth, as a fraction of full scale");
  visit("noise_level", tone.noise_level, Range{0, 0.3},
        "maximum amplitude of the cutting noise, as a fraction of full scale");
  visit("half_W", tone.half_W, Range{0.1, 10000},
        "cutting power at which its contribution to motor and noise is half of the maximum");
  visit("half_N", tone.half_N, Range{0.001, 1000},
        "amplitude of the teeth's force at which their tone has half of its maximum amplitude");
  visit("passing_share", p.passing_share, Range{0, 2},
        "amplitude of the force at the tooth-passing frequency, as a fraction of a tooth's mean force; an assumption "
        "(tooth_vibration: 0.46 in a block of 4 mm). Not used with tooth_vibration");
  visit("cutting_share", p.cutting_share, Range{0, 2},
        "cutting force of a tooth, as a fraction of its thrust, for the power; not used with tangential_force");
}

/// Records the inputs of the tone in each tick.
class SoundEffect final : public Effect {
 public:
  SoundEffect(const SoundParams& params, const EffectSetup& setup);

  void End(EffectEnd& end) override;
  void Reset() override { spindle_Hz_ = load_W_ = passing_N_ = 0; }
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override { return sizeof(*this); }

  const ToneParams& tone() const { return params_.tone; }
  double teeth() const { return teeth_; }

 private:
  SoundParams params_;
  double teeth_;                          // that pass in a turn or a double stroke
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
  double teeth() const { return teeth_; }
  /// `channels`: those of all effects. Tick-safe.
  ToneFrame Read(double dt_s, std::span<const double> channels) const;

 private:
  ToneParams tone_;
  double teeth_ = 0;
  int sound_ = -1;  // its first channel
  int runout_ = -1, set_ = -1, passing_ = -1;
};

}  // namespace kerf
