// structures: regions that must not be cut, the distance of the tool from them, and the volume cut from them.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "cut/effects/effect.h"
#include "cut/effects/structure_voxels.h"
#include "cut/proximity/box_tree.h"
#include "kerf/describe.h"

namespace kerf {

/// Distance from a tool to fixed boxes.
///
/// Round patches cover the tool. An Embree query finds the box nearest to a patch's centre, which gives a lower
/// bound for the whole patch, for this pose and for later ones. Patches whose bound is below the smallest known
/// distance are queried and divided into four, down to the tolerance. Starting from each result, the nearest points of
/// the tool and of the boxes are found alternately.
class StructureDistance {
 public:
  /// The result is the distance between a point of the tool and a point of a box. Patches smaller than this fraction of
  /// it, or than `kMin_mm`, are not divided further.
  static constexpr double kTolerance = 0.3;
  static constexpr double kMin_mm = 0.1;

  /// Allocates.
  StructureDistance(const std::vector<Box3>& boxes_F, const Tool& tool);

  struct Nearest {
    double distance_mm = 0;  // 0: in contact; the limit if no box is within it
    Vec3 p_F{0};             // point of a box; the tool's origin if no box is within the limit
  };
  /// Searches up to `limit_mm`. After `max_queries` Embree queries, or a few more, it returns the nearest point found
  /// so far, and the next call continues with the patches that were not queried. Tick-safe.
  Nearest Find(const Pose& X_FT, double limit_mm, std::size_t max_queries = kNoLimit);
  static constexpr std::size_t kNoLimit = static_cast<std::size_t>(-1);
  bool empty() const { return tree_.size() == 0; }
  std::size_t queries() const { return queries_; }  // Embree queries in the last Find()
  std::size_t CalcMemoryBytes() const;

 private:
  /// Part of a blade's middle plane, with half of the thickness on each side; or ball about a part of another tool.
  struct Patch {
    Vec3 p_T;
    double radius_mm;
  };
  void MakePatches();
  Vec3 FindNearestOfBody(const Vec3& p_T) const;
  double Reach(const Patch& patch) const { return std::hypot(patch.radius_mm, half_mm_); }
  double QueryPatch(const Pose& X_FT, const Patch& patch, Nearest& best);
  void SearchPatch(const Pose& X_FT, const Patch& patch, Nearest& best);

  BoxTree tree_;
  Tool tool_;
  ToolForm form_;
  ConvexOutline outline_;  // of a blade with a stroke: all that it passes
  double radius_mm_, half_mm_, reach_mm_;
  std::vector<Patch> patches_;
  std::vector<double> bound_mm_;      // distance of each patch's centre from the boxes
  std::vector<double> looked_at_mm_;  // value of travelled_mm_ when that distance was found
  double travelled_mm_ = 0;
  Pose X_looked_;
  std::size_t best_patch_ = 0;
  std::size_t first_patch_ = 0;  // the next Find() begins with it
  std::size_t queries_ = 0, max_queries_ = kNoLimit;
};

struct StructuresParams {
  std::string tissues = "canal";
  double warn_mm = 2;
  std::string surface, markups;  // names of files; empty: none
  double radius_mm = 0;

  // Set from these values, the bone's table and the files.
  std::array<bool, 256> regions{};
  std::shared_ptr<const EffectFile> surface_file = nullptr;
  std::shared_ptr<const EffectFile> markups_file = nullptr;
};

template <typename V>
void Describe(StructuresParams& p, V&& visit) {
  visit("tissues", p.tissues, Choices{{"canal", "tooth", "canal and tooth", "none"}},
        "tissues whose regions must not be cut");
  visit("warn_mm", p.warn_mm, Range{0, 20}, "distance below which the effect warns");
  visit("surface", p.surface, EffectFileKind::kSurface, "closed surface of an additional structure, mm");
  visit("markups", p.markups, EffectFileKind::kMarkups,
        "curves and points of 3D Slicer as additional structures: tubes and balls of radius_mm");
  visit("radius_mm", p.radius_mm, Range{0, 20}, "radius of the markups' tubes and balls; 0: no markups");
}

/// Event of a structure: the tool came near it, cut it, or moved away.
struct StructureEvent {
  enum class Kind { kNear, kBreach, kAway } kind = Kind::kNear;
  double time_s = 0;
  double distance_mm = 0;
  Vec3 p_W_mm{0};  // point of the structure nearest to the tool
};

/// Finds the distance of the tool from structures, warns below a margin, and measures the volume cut from them.
class StructuresEffect final : public Effect {
 public:
  /// Throws Error if a structure from a file is too far from the bone or too fine for its voxels.
  StructuresEffect(const StructuresParams& params, const EffectSetup& setup);

  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void Reset() override { looked_ = false; }
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override;

  // ---- any time
  /// Distance of the tool from the nearest voxel of a structure, mm; `kLook_mm` if none is nearer than that.
  double distance_mm() const { return distance_mm_; }
  double warn_mm() const { return warn_mm_; }
  const StructureVoxels& voxels() const { return voxels_; }
  const std::vector<StructureEvent>& events() const { return events_; }  // the first kMaxEvents
  static constexpr double kLook_mm = 20;
  static constexpr std::size_t kMaxEvents = 256;

 private:
  void RecordEvent(StructureEvent::Kind kind);

  std::array<bool, 256> regions_;
  double warn_mm_;
  Vec3 p_WF_mm_;
  StructureVoxels voxels_;
  bool from_files_;
  double ahead_mm_;  // distance in front of the teeth at which their material is read
  StructureDistance distance_;
  BoxTree shell_;
  Pose X_looked_;
  double reach_mm_;
  bool looked_ = false, found_ = false;
  double distance_mm_ = kLook_mm, looked_mm_ = kLook_mm;
  Vec3 p_F_mm_{0};
  double time_s_ = 0;
  bool near_ = false, in_breach_ = false;
  double cut_fraction_ = 0, cut_all_ = 0, force_now_N_ = 0;  // in this tick
  std::size_t next_tooth_ = 0;                               // next tooth in breach whose depth is computed
  double breach_mm3_ = 0, breach_depth_mm_ = 0, breach_force_N_ = 0;
  std::vector<StructureEvent> events_;
};

}  // namespace kerf
