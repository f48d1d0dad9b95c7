// structures: what must not be cut, how near the blade is to it, and what was cut of it.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "cut/effects/effect.h"
#include "cut/effects/structure_voxels.h"
#include "cut/proximity/box_tree.h"

namespace kerf {

/// Distance from a tool to boxes that stay where they are.
///
/// Round patches cover the tool. A query of Embree gives the box that is nearest to a patch's centre, and with it a
/// lower bound for the whole patch, now and while the tool moves on. Patches whose bound lies below the least distance
/// known are asked, and divided in four, down to the tolerance; from each answer the nearest points of tool and boxes
/// are found in turn.
class StructureDistance {
 public:
  /// What is given is the distance of a point of the tool to a point of a box. Where patches are this share of it
  /// small, or so many mm, they are divided no further.
  static constexpr double kTolerance = 0.3;
  static constexpr double kLeast_mm = 0.1;

  /// Allocates.
  StructureDistance(const std::vector<Box3>& boxes_F, const Tool& tool);

  struct Nearest {
    double distance_mm = 0;  // 0: they touch; the limit when nothing is as near
    Vec3 p_F{0};             // of the boxes; the tool's origin when nothing is
  };
  /// Further than `limit_mm` is not looked. After `most_queries` of Embree it ends with the nearest found until then,
  /// and the next call goes on with the patches that were not asked; a few more may be made. Tick-safe.
  Nearest Find(const Pose& X_FT, double limit_mm, std::size_t most_queries = kNoLimit);
  static constexpr std::size_t kNoLimit = static_cast<std::size_t>(-1);
  bool empty() const { return tree_.size() == 0; }
  std::size_t queries() const { return queries_; }  // of Embree, in the last Find()
  std::size_t patch_count() const { return patches_.size(); }
  std::size_t CalcMemoryBytes() const;

 private:
  /// Of the disc's middle plane; the thickness is on both sides of it.
  struct Patch {
    Vec3 p_T;
    double radius_mm;
  };
  void MakePatches();
  double Reach(const Patch& patch) const { return std::hypot(patch.radius_mm, half_mm_); }
  Vec3 NearestOfTool(const Vec3& p_T) const;
  double Ask(const Pose& X_FT, const Patch& patch, Nearest& best);
  void Divide(const Pose& X_FT, const Patch& patch, Nearest& best);

  BoxTree tree_;
  bool is_disc_;
  double radius_mm_, half_mm_, reach_mm_;
  std::vector<Patch> patches_;
  std::vector<double> bound_mm_;      // of each patch's centre from the boxes,
  std::vector<double> looked_at_mm_;  // when so much was travelled
  double travelled_mm_ = 0;
  Pose X_looked_;
  std::size_t best_patch_ = 0;
  std::size_t first_patch_ = 0;  // with which the next Find() begins
  std::size_t queries_ = 0, most_queries_ = kNoLimit;
};

struct StructuresParams {
  std::array<bool, 256> regions{};
  double warn_mm = 2;
  // From files, beside the regions; null: none.
  std::shared_ptr<const EffectFile> surface = nullptr;
  std::shared_ptr<const EffectFile> markups = nullptr;
  double radius_mm = 0;  // of the markups' tubes and balls
};

/// Something that happened to a structure.
struct StructureEvent {
  enum class Kind { kNear, kBreach, kAway } kind = Kind::kNear;
  double time_s = 0;
  double distance_mm = 0;
  Vec3 p_W_mm{0};  // of the structure, nearest to the tool
};

class StructuresEffect final : public Effect {
 public:
  /// Throws Error for a file's structure that is too far from the bone or too fine for its voxels.
  StructuresEffect(const StructuresParams& params, const EffectSetup& setup);

  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void Reset() override { looked_ = false; }
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override;

  // ---- any time
  /// Of the blade from the nearest voxel of a structure, mm; `kLook_mm` when none is as near.
  double distance_mm() const { return distance_mm_; }
  double warn_mm() const { return warn_mm_; }
  const StructureVoxels& voxels() const { return voxels_; }
  const std::vector<StructureEvent>& events() const { return events_; }  // the first kMostEvents
  static constexpr double kLook_mm = 20;
  static constexpr std::size_t kMostEvents = 256;

 private:
  void Note(StructureEvent::Kind kind);

  std::array<bool, 256> regions_;
  double warn_mm_;
  Vec3 p_WF_mm_;
  StructureVoxels voxels_;
  bool from_files_;
  double ahead_mm_;  // of the teeth: where their material is looked up
  StructureDistance distance_;
  BoxTree shell_;
  Pose X_looked_;
  double reach_mm_;
  bool looked_ = false, found_ = false;
  double distance_mm_ = kLook_mm, looked_mm_ = kLook_mm;
  Vec3 p_F_mm_{0};
  double time_s_ = 0;
  bool near_ = false, in_breach_ = false;
  double cut_share_ = 0, cut_all_ = 0, force_now_N_ = 0;  // of this tick
  std::size_t next_tooth_ = 0;                            // of those in breach: whose depth is looked up next
  double breach_mm3_ = 0, breach_depth_mm_ = 0, breach_force_N_ = 0;
  std::vector<StructureEvent> events_;
};

}  // namespace kerf
