// What the effects of a run leave behind besides their figures: sounds and pictures of their own.
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

/// Keeps, tick by tick, what the files are made of. Of a scene without such effects it is empty and does nothing.
class EffectFiles {
 public:
  EffectFiles() = default;
  /// `ticks`: that will come, for setting memory aside. `here`: Take() is called in the thread that makes the ticks,
  /// and may look at the effects themselves until Finish(): then there are a spectrum and
  /// chips too. `folder`: where the sound goes as it comes, so that memory does not grow with the run; "": its ticks
  /// are kept. Throws Error when it can't be written there.
  EffectFiles(const EffectPlan& plan, std::size_t ticks, bool here, const std::string& folder = "");

  /// A tick that is over; `channels` of all effects.
  void Take(double time_s, double dt_s, const Pose& X_WT, std::span<const double> channels);
  /// No tick comes any more; the plan may go.
  void Finish() {
    spectrum_.Detach();
    chips_.Detach();
  }

  /// Write what there is into the folder and return the names. Throw Error. Sounds once, and into the folder that the
  /// constructor got, if any.
  std::vector<std::string> WriteSounds(const std::string& folder);
  std::vector<std::string> WritePictures(const std::string& folder, const std::string& name, const Bone& bone,
                                         const Tool& tool, bool patient) const;
  /// All names that they may give.
  static const std::vector<std::string>& Names();

 private:
  SoundTrack sound_;
  SpectrumTrack spectrum_;
  GuideTrack guide_;
  ChipsTrack chips_;
  StructuresTrack structures_;
};

}  // namespace kerf
