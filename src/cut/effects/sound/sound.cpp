// sound: the tone of motor and cut, from spindle speed and load.
//
// The tick records three values: the spindle frequency, the cutting power, and the amplitude of the teeth's force at
// their frequency. The samples are made outside the tick (tone.h), by the code that writes or plays them.
#include "cut/effects/sound/sound.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <variant>

#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"
#include "cut/effects/plan.h"
#include "cut/effects/tangential_force.h"

namespace kerf {
SoundEffect::SoundEffect(const SoundParams& params, const EffectSetup& setup)
    : params_(params),
      teeth_(setup.shape.passes_per_turn),
      cutting_(dynamic_cast<const TangentialForceEffect*>(setup.plan->Find("tangential_force"))) {
  const Drive drive(setup.tool);
  if (!drive.strokes()) return;
  teeth_ = drive.passes_per_period();
}

void SoundEffect::End(EffectEnd& end) {
  spindle_Hz_ = std::abs(end.rpm) / 60;
  const bool cuts = end.engaged_teeth > 0 && end.rpm != 0;
  passing_N_ = cuts ? params_.passing_share * end.thrust_sum_N / std::max(1.0, end.engaged_teeth) : 0;
  load_W_ = 0;
  if (cuts) {
    load_W_ = cutting_ != nullptr ? cutting_->figures().power_W : params_.cutting_share * end.thrust_W;
  }
}

void SoundEffect::Report(std::span<double> channels) const {
  channels[0] = spindle_Hz_;
  channels[1] = load_W_;
  channels[2] = passing_N_;
}

ToneReader::ToneReader(const EffectPlan& plan) {
  const auto* sound = dynamic_cast<const SoundEffect*>(plan.Find("sound"));
  if (sound == nullptr) return;
  tone_ = sound->tone();
  teeth_ = sound->teeth();
  for (const EffectPlan::Entry& entry : plan.entries()) {
    const std::string_view effect = entry.info->name;
    if (effect == "sound") sound_ = static_cast<int>(entry.first_channel);
    for (std::size_t i = 0; effect == "tooth_vibration" && i < entry.info->channels.size(); ++i) {
      const std::string_view channel = entry.info->channels[i].name;
      const int at = static_cast<int>(entry.first_channel + i);
      if (channel == "runout_N") runout_ = at;
      if (channel == "set_N") set_ = at;
      if (channel == "passing_N") passing_ = at;
    }
  }
}

ToneFrame ToneReader::Read(double dt_s, std::span<const double> channels) const {
  const auto at = [&](int channel) { return static_cast<float>(channels[static_cast<std::size_t>(channel)]); };
  ToneFrame frame;
  frame.dt_s = static_cast<float>(dt_s);
  frame.spindle_Hz = at(sound_);
  frame.load_W = at(sound_ + 1);
  frame.passing_N = at(passing_ >= 0 ? passing_ : sound_ + 2);
  if (runout_ >= 0) frame.runout_N = at(runout_);
  if (set_ >= 0) frame.set_N = at(set_);
  return frame;
}

const EffectInfo& Sound() {
  static const EffectInfo kEffect{
      .name = "sound",
      .summary = "the tone of motor and cut, from spindle speed and load, as a sound file",
      .source =
          "lines at multiples of the spindle's and the tooth-passing frequency; all loudnesses and the motor's order "
          "are assumptions: no recording of a saw in bone was analysed",
      .reads = "spindle speed, thrust and number of the teeth, cutting power",
      .writes = "nothing in the tick; the file sound.wav of a run",
      .state = "values of the last tick",
      .sleeps = "never: a tick stores three numbers",
      .hooks = kEffectEnd,
      .parameters = ListEffectParameters<SoundParams>(),
      .channels =
          {{"spindle_Hz", "rotations of the spindle per second"},
           {"load_W", "cutting power"},
           {"passing_N",
            "amplitude of the teeth's force at their frequency, an estimate that is used without tooth_vibration"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        return std::make_unique<SoundEffect>(ReadEffectParameters<SoundParams>(values), setup);
      }};
  return kEffect;
}

}  // namespace kerf
