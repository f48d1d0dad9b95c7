// Picture of the plan that the effect "guide" enforces and of the tool's motion.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/core/thinned.h"
#include "cut/effects/guide.h"
#include "cut/effects/plan.h"
#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf {

/// Records the tool's positions and their distance from the plan. Does nothing if the plan has no guide.
class GuideTrack {
 public:
  GuideTrack() = default;
  /// `ticks`: expected number of ticks.
  GuideTrack(const EffectPlan& plan, std::size_t ticks);

  void Take(double time_s, const Vec3& p_WT_mm, std::span<const double> channels);

  struct Moment {
    float time_s, deviation_mm, force_N;
    Vec3 p_WT_mm;
    /// Combines two points: keeps the first's time and position and the larger of each value.
    static Moment Merge(const Moment& a, const Moment& b) {
      return {a.time_s, std::max(a.deviation_mm, b.deviation_mm), std::max(a.force_N, b.force_N), a.p_WT_mm};
    }
  };
  static constexpr std::size_t kMaxMoments = std::size_t{1} << 17;  // one per tick, or per several ticks in a long run
  const std::optional<GuideParams>& guide() const { return guide_; }
  const std::vector<Moment>& moments() const { return moments_.points(); }

 private:
  std::optional<GuideParams> guide_;
  std::size_t deviation_ = 0, force_ = 0;  // indices of the channels
  Thinned<Moment, kMaxMoments> moments_;
};

/// Draws the plane with its tolerance, the stops and the motion of the tool's centre in the bone.
void WriteGuidePicture(const GuideTrack& track, const Bone& bone, const Tool& tool, bool patient,
                       const std::string& name, const std::string& path);
/// Plots the distance from the plane and the guide's force over time.
void WriteDeviationPlot(const GuideTrack& track, const std::string& name, const std::string& path);

}  // namespace kerf
