// What the effects of a run leave behind besides their figures: sounds and pictures of their own.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "effects/sound/sound.h"

namespace kerf {

class EffectPlan;

/// Keeps, tick by tick, what the files are made of. Of a scene without such effects it is empty and does nothing.
class EffectFiles {
 public:
  EffectFiles() = default;
  /// `ticks`: that will come, for setting memory aside.
  EffectFiles(const EffectPlan& plan, std::size_t ticks);

  /// A tick that is over; `channels` of all effects.
  void Take(double dt_s, std::span<const double> channels);

  /// Writes what there is into the folder: sound.wav. Returns the names. Throws Error.
  std::vector<std::string> Write(const std::string& folder) const;
  /// All names that Write() may give.
  static const std::vector<std::string>& Names();

 private:
  void WriteSound(const std::string& path) const;

  ToneReader tone_;
  std::vector<ToneFrame> tones_;
};

}  // namespace kerf
