#include "session/run/sound_track.h"

#include <algorithm>

#include "cut/effects/plan.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kFramesAtOnce = 256;
constexpr float kFade_s = 0.01F;  // fade-out at the end, because an abrupt stop is audible as a click

}  // namespace

SoundTrack::SoundTrack(const EffectPlan& plan, std::size_t ticks, const std::string& path) : reader_(plan) {
  if (!reader_.any()) return;
  tone_.emplace(reader_.tone(), reader_.teeth());
  frames_.reserve(path.empty() ? ticks : kFramesAtOnce);
  if (!path.empty()) file_.emplace(path, reader_.tone().rate_Hz);
}

void SoundTrack::Take(double dt_s, std::span<const double> channels) {
  if (!reader_.any()) return;
  any_ = true;
  last_ = reader_.Read(dt_s, channels);
  frames_.push_back(last_);
  if (file_ && frames_.size() == kFramesAtOnce) Render();
}

void SoundTrack::Render() {
  for (std::size_t done = 0; done < frames_.size() && failure_.empty(); done += kFramesAtOnce) {
    samples_.clear();
    const std::size_t end = std::min(frames_.size(), done + kFramesAtOnce);
    for (std::size_t i = done; i < end; ++i) tone_->Render(frames_[i], samples_);
    try {
      file_->Append(samples_);
    } catch (const Error& e) {
      failure_ = e.what();
    }
  }
  frames_.clear();
}

bool SoundTrack::Write(const std::string& path) {
  if (!any_) {
    file_.reset();
    return false;
  }
  if (!file_) file_.emplace(path, reader_.tone().rate_Hz);
  ToneFrame silence;
  silence.dt_s = kFade_s;
  silence.spindle_Hz = last_.spindle_Hz;
  frames_.push_back(silence);
  Render();
  if (!failure_.empty()) throw Error(failure_);
  file_->Commit();
  file_.reset();
  return true;
}

}  // namespace kerf
