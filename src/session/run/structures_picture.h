// Picture of the blade's smallest distance to the structures that the effect "structures" monitors, and its location.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/core/thinned.h"
#include "cut/effects/plan.h"
#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Records the distance over time, and the pose at which the tool was closest or deepest. Does nothing if the plan has
/// no structures.
class StructuresTrack {
 public:
  StructuresTrack() = default;
  /// `ticks`: expected number of ticks.
  StructuresTrack(const EffectPlan& plan, std::size_t ticks);

  void Take(double time_s, const Pose& X_WT, std::span<const double> channels);

  struct Moment {
    float time_s, distance_mm, breach_mm3;  // breach_mm3: total so far
    static Moment Merge(const Moment& a, const Moment& b) {
      return {a.time_s, std::min(a.distance_mm, b.distance_mm), b.breach_mm3};
    }
  };
  static constexpr std::size_t kMaxMoments = std::size_t{1} << 17;  // one per tick, or per several ticks in a long run
  const std::vector<Moment>& moments() const { return moments_.points(); }
  const TriangleMesh& surface_W() const { return surface_W_; }
  double warn_mm() const { return warn_mm_; }

  struct Closest {
    Pose X_WT;
    double time_s, distance_mm, depth_mm, force_N;  // depth_mm and force_N: of the breach so far
  };
  const std::optional<Closest>& closest() const { return closest_; }

 private:
  std::optional<std::size_t> first_channel_;
  double warn_mm_ = 0;
  TriangleMesh surface_W_;
  Thinned<Moment, kMaxMoments> moments_;
  std::optional<Closest> closest_;
};

/// Draws the structures in the translucent bone with the blade where it was closest to them and, below, the distance
/// over time.
void WriteStructuresPicture(const StructuresTrack& track, const Bone& bone, const Tool& tool, bool patient,
                            const std::string& name, const std::string& path);

}  // namespace kerf
