// The sound of a run with the effect "sound": kept as what it goes by, or written as it comes.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cut/effects/sound/sound.h"
#include "view/audio/wav.h"

namespace kerf {

/// Of a plan without the effect it does nothing.
class SoundTrack {
 public:
  SoundTrack() = default;
  /// `path`: of the file that grows with the run; "": 28 bytes a tick are kept until Write(). `ticks`: that will come.
  /// Throws Error when the file can't be made.
  SoundTrack(const EffectPlan& plan, std::size_t ticks, const std::string& path);

  /// A tick that is over; `channels` of all effects. A disk that is full does not stop the run: Write() tells it.
  void Take(double dt_s, std::span<const double> channels);
  /// False: there was nothing to hear. `path` is the constructor's, if that got one. Throws Error. Once.
  bool Write(const std::string& path);

 private:
  void Render();

  ToneReader reader_;
  std::vector<ToneFrame> frames_;  // not rendered yet
  bool any_ = false;
  ToneFrame last_;
  std::optional<Tone> tone_;
  std::optional<WavFile> file_;
  std::vector<float> samples_;
  std::string failure_;  // a sentence; empty when all went well
};

}  // namespace kerf
