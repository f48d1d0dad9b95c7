#include "app/window/beeper.h"

#include <alsa/asoundlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <thread>

namespace kerf {
namespace {

constexpr std::size_t kBlock = 480;  // 10 ms

void IgnoreAlsaError(const char*, int, const char*, int, const char*, ...) {}

}  // namespace

struct Beeper::State {
  snd_pcm_t* out = nullptr;
  mutable std::mutex mutex;  // protects `sound`, for the time of a copy
  SoundState sound;
  std::atomic<bool> stop{false};
  std::thread thread;

  SoundState Get() const {
    const std::lock_guard lock(mutex);
    return sound;
  }
  void Play() {
    SoundGenerator generator;
    std::array<std::int16_t, kBlock> block{};
    while (!stop.load()) {
      generator.Fill(Get(), block);
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
  if (snd_pcm_set_params(state_->out, SND_PCM_FORMAT_S16, SND_PCM_ACCESS_RW_INTERLEAVED, 1, SoundGenerator::kRate_Hz, 1,
                         kLatency_us) != 0) {
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

bool Beeper::has_sound() const {
  return state_->out != nullptr;
}

void Beeper::SetAlarm(AlarmKind kind, std::optional<double> distance_mm) {
  const std::lock_guard lock(state_->mutex);
  state_->sound.alarms_mm[static_cast<std::size_t>(kind)] = distance_mm;
}

void Beeper::SetSaw(double rpm, double force_N) {
  const std::lock_guard lock(state_->mutex);
  state_->sound.rpm = rpm;
  state_->sound.force_N = force_N;
}

void Beeper::SetVolume(double percent) {
  const std::lock_guard lock(state_->mutex);
  state_->sound.volume = std::clamp(percent, 0.0, 100.0) / 100;
}

void Beeper::SetMuted(bool muted) {
  const std::lock_guard lock(state_->mutex);
  state_->sound.muted = muted;
}

double Beeper::volume_percent() const {
  return 100 * state_->Get().volume;
}

bool Beeper::muted() const {
  return state_->Get().muted;
}

}  // namespace kerf
