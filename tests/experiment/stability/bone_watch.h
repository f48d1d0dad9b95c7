// Invariants of the bone under a saw, whatever moves it, checked against a copy of the bone before the cut.
#pragma once

#include <string>
#include <vector>

#include "bone/grid/field.h"
#include "cut/removal/cutter.h"
#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf::test {

/// Records the tool's poses since its construction and reports every change of the bone that contradicts them:
///
///   I4 volume is conserved: removed + remaining = before
///   I5 phi only rises
///   I6 nothing changes that is further from the tool's positions than the band; within the band no voxel rises above
///      -(distance to the swept space), so that only voxels within half a voxel of that space lose occupancy. (The
///      catalogue's "unchanged outside the swept space dilated by one voxel" is about voxels that are present or
///      absent. A level set represents the kerf's walls by its values within three voxels of them.)
///   I7 everything that the edge passed is removed: no voxel there is below -(distance to the tool)
class BoneWatch {
 public:
  BoneWatch(const Bone& before, const Tool& tool, CutWith with);

  /// Records a motion of the tool in one tick. `stray_mm`: maximum distance of any of its parts from the straight line.
  /// `cut`: true if the edge certainly cut at X_to.
  void Move(const Pose& X_from, const Pose& X_to, double stray_mm, bool cut);

  /// Sum of the occupancy removed by the ticks, and exact removed volume since construction. A negative value is
  /// unknown and is not checked.
  struct Removed {
    double by_ticks_mm3 = -1;
    double exact_mm3 = -1;
  };
  /// Returns every violation with its figure, at most one of each kind. The next check compares with the bone of this
  /// one.
  std::vector<std::string> Check(const Bone& after, const Removed& removed);

  const Bone& before() const { return before_; }
  /// Returns true if any part of the tool, moving straight between the two poses, is within `margin_mm` of the bone's
  /// box.
  bool MayTouch(const Pose& X_from, const Pose& X_to, double margin_mm) const;

 private:
  struct Passed {
    Pose X_WT;
    double stray_mm;
    bool cut;
  };
  double CalcDistance(const Pose& X_WT, const Vec3& p_W) const;
  void CheckEdges(const BoneField& field, std::vector<std::string>& found) const;

  Bone before_;
  Tool tool_;
  CutWith with_;
  double h_;
  double reach_mm_;
  Box3 box_;
  double removed_mm3_ = 0;  // exact, at the last check
  std::vector<Passed> passed_;
};

}  // namespace kerf::test
