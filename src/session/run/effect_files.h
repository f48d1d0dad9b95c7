// Files that the effects of a run produce in addition to their channels: sounds and pictures.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"
#include "session/run/chips_picture.h"
#include "session/run/guide_picture.h"
#include "session/run/sound_track.h"
#include "session/run/spectrum_picture.h"
#include "session/run/structures_picture.h"

namespace kerf {

/// Collects the data for the files tick by tick. Does nothing if the scene has no such effects.
class EffectFiles {
 public:
  EffectFiles() = default;
  /// `ticks`: expected number of ticks, for reserving memory. `in_tick_thread`: true if Take() is called in the thread
  /// that runs the ticks and may therefore access the effects until Finish(); the spectrum and the chips require this.
  /// `folder`: the sound is written there during the run, so that memory does not grow; "": its parameters are kept in
  /// memory. Throws kerf::Error if the file cannot be written.
  EffectFiles(const EffectPlan& plan, std::size_t ticks, bool in_tick_thread, const std::string& folder = "");

  /// Call after each tick. `channels`: the channels of all effects.
  void Take(double time_s, double dt_s, const Pose& X_WT, std::span<const double> channels);
  /// Call after the last tick; the plan may be destroyed afterwards.
  void Finish() {
    spectrum_.Detach();
    chips_.Detach();
  }

  /// Write the available files into the folder and return their names. Throw kerf::Error. Call WriteSounds() once, with
  /// the constructor's folder if that was set.
  std::vector<std::string> WriteSounds(const std::string& folder);
  std::vector<std::string> WritePictures(const std::string& folder, const std::string& name, const Bone& bone,
                                         const Tool& tool, bool patient) const;
  /// Returns all names that these functions may return.
  static const std::vector<std::string>& Names();

 private:
  SoundTrack sound_;
  SpectrumTrack spectrum_;
  GuideTrack guide_;
  ChipsTrack chips_;
  StructuresTrack structures_;
};

}  // namespace kerf
