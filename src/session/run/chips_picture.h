// The chips in the air, of a run with the effect "chips".
#pragma once

#include <optional>
#include <string>

#include "cut/effects/chips.h"
#include "cut/effects/plan.h"
#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf {

/// Keeps the chips of the tick in which most were in the air. Of a plan without the effect it does nothing.
class ChipsTrack {
 public:
  ChipsTrack() = default;
  explicit ChipsTrack(const EffectPlan& plan);

  /// After a tick; in the thread that makes it.
  void Take(double time_s, const Pose& X_WT);
  /// The plan ends.
  void Detach() { effect_ = nullptr; }

  struct Moment {
    double time_s = 0;
    Pose X_WT;
    ChipPool pool;
    double emitted_mm3 = 0, dropped_mm3 = 0;  // up to then
  };
  /// None: no chip ever flew.
  const std::optional<Moment>& most() const { return most_; }
  const ChipsParams& params() const { return params_; }
  const Vec3& p_WF_mm() const { return p_WF_mm_; }

 private:
  const ChipsEffect* effect_ = nullptr;
  ChipsParams params_;
  Vec3 p_WF_mm_{0};
  std::optional<Moment> most_;
};

/// Bone, tool and chips in that tick. False: there was nothing to draw.
bool WriteChipsPicture(const ChipsTrack& track, const Bone& bone, const Tool& tool, bool patient,
                       const std::string& name, const std::string& path);

}  // namespace kerf
