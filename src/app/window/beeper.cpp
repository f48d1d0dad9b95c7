#include "app/window/beeper.h"

#include <alsa/asoundlib.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

namespace kerf {
namespace {

constexpr unsigned kRate_Hz = 48'000;
constexpr std::size_t kBlock = 480;  // 10 ms
constexpr double kLoudness = 6000;   // amplitude; the maximum is 32767
constexpr double kSilent = std::numeric_limits<double>::quiet_NaN();

void IgnoreAlsaError(const char*, int, const char*, int, const char*, ...) {}

}  // namespace

Beep CalcBeep(std::optional<double> to_goal_mm) {
  constexpr double kFrom_mm = 3;
  constexpr double kThere_mm = 0.2;
  if (!to_goal_mm || std::isnan(*to_goal_mm) || *to_goal_mm > kFrom_mm) return {};
  if (*to_goal_mm < -kThere_mm) return {.per_s = std::numeric_limits<double>::infinity(), .pitch_Hz = 1320};
  if (*to_goal_mm < kThere_mm) return {.per_s = std::numeric_limits<double>::infinity(), .pitch_Hz = 880};
  // 2 beeps per second at 3 mm before the goal, 10 per second at 0.2 mm before it.
  return {.per_s = 2 + 8 * (kFrom_mm - *to_goal_mm) / (kFrom_mm - kThere_mm), .pitch_Hz = 880};
}

struct Beeper::State {
  snd_pcm_t* out = nullptr;
  std::atomic<double> to_goal_mm{kSilent};
  std::atomic<bool> stop{false};
  std::thread thread;

  void Play() {
    std::array<std::int16_t, kBlock> block{};
    double phase = 0;     // of the tone, cycles
    double beat = 0;      // of the beeps, cycles
    double loudness = 0;  // changes within a few ms to avoid clicks
    double pitch_Hz = 880;
    while (!stop.load()) {
      const double now_mm = to_goal_mm.load();
      const Beep beep = CalcBeep(std::isnan(now_mm) ? std::nullopt : std::optional(now_mm));
      if (beep.per_s > 0) pitch_Hz = beep.pitch_Hz;
      for (std::int16_t& sample : block) {
        const bool steady = std::isinf(beep.per_s);
        if (!steady) beat += beep.per_s / kRate_Hz;
        const bool on = steady || (beep.per_s > 0 && beat - std::floor(beat) < 0.5);
        loudness += ((on ? kLoudness : 0) - loudness) / 240;
        phase += pitch_Hz / kRate_Hz;
        sample = static_cast<std::int16_t>(
            std::lround(loudness * std::sin(2 * std::numbers::pi * (phase - std::floor(phase)))));
      }
      const snd_pcm_sframes_t written = snd_pcm_writei(out, block.data(), block.size());
      if (written < 0 && snd_pcm_recover(out, static_cast<int>(written), 1) < 0) return;  // audio device removed
    }
  }
};

Beeper::Beeper() : state_(std::make_unique<State>()) {
  snd_lib_error_set_handler(IgnoreAlsaError);
  if (snd_pcm_open(&state_->out, "default", SND_PCM_STREAM_PLAYBACK, 0) != 0) {
    state_->out = nullptr;
    return;
  }
  constexpr unsigned kLatency_us = 50'000;
  if (snd_pcm_set_params(state_->out, SND_PCM_FORMAT_S16, SND_PCM_ACCESS_RW_INTERLEAVED, 1, kRate_Hz, 1, kLatency_us) !=
      0) {
    snd_pcm_close(state_->out);
    state_->out = nullptr;
    return;
  }
  state_->thread = std::thread([this] { state_->Play(); });
}

Beeper::~Beeper() {
  state_->stop.store(true);
  if (state_->thread.joinable()) state_->thread.join();
  if (state_->out != nullptr) snd_pcm_close(state_->out);
}

void Beeper::Set(std::optional<double> to_goal_mm) {
  state_->to_goal_mm.store(to_goal_mm.value_or(kSilent));
}

}  // namespace kerf
