// Cutting as one would implement it with OpenVDB alone: each tick creates a new level set of the tool, which the
// library's difference operation removes from the bone.
#pragma once

#include <memory>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// A bone that is cut with OpenVDB, in one thread.
class VdbCut {
 public:
  /// The object works on its own copy of the bone.
  explicit VdbCut(Bone bone);
  ~VdbCut();

  /// Creates a level set of the tool at its pose with the bone's voxel size and band, by filling the leaves at its
  /// surface in single precision, and removes it with openvdb::tools::csgDifference(). The library's own functions that
  /// create level sets (of spheres, of meshes) take longer. The bone is not pruned, which also saves time.
  void Cut(const Tool& tool, const Pose& X_WT);

  const Bone& bone() const { return bone_; }

 private:
  Bone bone_;
};

}  // namespace kerf
