// Picture of the flying chips, for a run with the effect "chips".
#pragma once

#include <optional>
#include <string>

#include "cut/effects/chips.h"
#include "cut/effects/plan.h"
#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf {

/// Keeps the chips of the tick with the most chips in the air. Does nothing if the plan lacks the effect.
class ChipsTrack {
 public:
  ChipsTrack() = default;
  explicit ChipsTrack(const EffectPlan& plan);

  /// Call after each tick, in the thread that runs the tick.
  void Take(double time_s, const Pose& X_WT);
  /// Call before the plan is destroyed.
  void Detach() { effect_ = nullptr; }

  struct Moment {
    double time_s = 0;
    Pose X_WT;
    ChipPool pool;
    double emitted_mm3 = 0, dropped_mm3 = 0;  // total so far
  };
  /// Returns the tick with the most chips; none if no chip was ever in the air.
  const std::optional<Moment>& peak() const { return peak_; }
  const ChipsParams& params() const { return params_; }
  const Vec3& p_WF_mm() const { return p_WF_mm_; }

 private:
  const ChipsEffect* effect_ = nullptr;
  ChipsParams params_;
  Vec3 p_WF_mm_{0};
  std::optional<Moment> peak_;
};

/// Draws the bone, the tool and the chips in that tick. Returns false if there was nothing to draw.
bool WriteChipsPicture(const ChipsTrack& track, const Bone& bone, const Tool& tool, bool patient,
                       const std::string& name, const std::string& path);

}  // namespace kerf
