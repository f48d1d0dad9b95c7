// The plan that the effect "guide" keeps the tool to, and where the tool went.
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

/// Keeps the tool's way and its distance from the plan. Of a plan without a guide it does nothing.
class GuideTrack {
 public:
  GuideTrack() = default;
  /// `ticks`: that will come.
  GuideTrack(const EffectPlan& plan, std::size_t ticks);

  void Take(double time_s, const Vec3& p_WT_mm, std::span<const double> channels);

  struct Moment {
    float time_s, deviation_mm, force_N;
    Vec3 p_WT_mm;
    /// The largest of both, from the first on.
    static Moment Merge(const Moment& a, const Moment& b) {
      return {a.time_s, std::max(a.deviation_mm, b.deviation_mm), std::max(a.force_N, b.force_N), a.p_WT_mm};
    }
  };
  static constexpr std::size_t kMostMoments = std::size_t{1} << 17;  // each a tick, in a longer run several
  const std::optional<GuideParams>& guide() const { return guide_; }
  const std::vector<Moment>& moments() const { return moments_.points(); }

 private:
  std::optional<GuideParams> guide_;
  std::size_t deviation_ = 0, force_ = 0;  // channels
  Thinned<Moment, kMostMoments> moments_;
};

/// Plane with its tolerance, stops and the way of the tool's middle, in the bone.
void WriteGuidePicture(const GuideTrack& track, const Bone& bone, const Tool& tool, bool patient,
                       const std::string& name, const std::string& path);
/// Distance from the plane, and the guide's force, over time.
void WriteDeviationPlot(const GuideTrack& track, const std::string& name, const std::string& path);

}  // namespace kerf
