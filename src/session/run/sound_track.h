// Sound of a run with the effect "sound": its parameters are kept in memory, or it is written during the run.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cut/effects/sound/sound.h"
#include "view/audio/wav.h"

namespace kerf {

/// Does nothing if the plan lacks the effect.
class SoundTrack {
 public:
  SoundTrack() = default;
  /// `path`: file that grows with the run; "": 28 bytes per tick are kept until Write(). `ticks`: expected number of
  /// ticks. Throws kerf::Error if the file cannot be created.
  SoundTrack(const EffectPlan& plan, std::size_t ticks, const std::string& path);

  /// Call after each tick. `channels`: the channels of all effects. A full disk does not stop the run: Write() reports
  /// it.
  void Take(double dt_s, std::span<const double> channels);
  /// Returns false if there was no sound. `path`: must be the constructor's, if that was set. Throws kerf::Error. Call
  /// once.
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
  std::string failure_;  // one sentence; empty if no error occurred
};

}  // namespace kerf
