// What a saw may do to a bone, whatever moves it: held against a copy of the bone as it was.
#pragma once

#include <string>
#include <vector>

#include "bone/grid/field.h"
#include "cut/removal/cutter.h"
#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf::test {

/// Keeps where the tool has been since it was made, and then says what in the bone does not go with that:
///
///   I4 volume is conserved: removed + remaining = before
///   I5 phi only rises
///   I6 nothing changes that is further than the band from where the tool was; within it no voxel rises above
///      -(distance to the swept space), so that no voxel loses any of its occupancy that is not within half a voxel of
///      it. (The catalogue's "unchanged outside the swept space dilated by one voxel" is about voxels that are there or
///      not; a level set has the kerf's walls in its values for three voxels around.)
///   I7 and what the edge passed is gone: there no voxel lies below -(distance to the tool)
class BoneWatch {
 public:
  BoneWatch(const Bone& before, const Tool& tool, CutWith with);

  /// The tool moved, in one tick. `stray_mm`: how far from the straight way any part of it may have been. `cut`: for
  /// certain the edge cut at X_to.
  void Move(const Pose& X_from, const Pose& X_to, double stray_mm, bool cut);

  /// Sum of occupancy by the ticks, and the exact one since the watch began; not negative, or what is not known is not
  /// looked at.
  struct Removed {
    double by_ticks_mm3 = -1;
    double exact_mm3 = -1;
  };
  /// What does not hold, each with its figure; at most one of a kind. The bone as it is now is the one to hold against
  /// from then on.
  std::vector<std::string> Check(const Bone& after, const Removed& removed);

  const Bone& before() const { return before_; }
  /// Any part of the tool, moving straight from the one to the other, within `margin_mm` of the bone's box.
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
