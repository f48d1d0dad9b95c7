// Cutting as one would implement it with OpenVDB: each tick creates a new level set of the tool, which the library's
// difference operation removes from the bone; or it writes the tool's distance into the bone's own leaves.
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
  /// surface in single precision. The library's own functions that create level sets (of spheres, of meshes) take
  /// longer.
  void MakeTool(const Tool& tool, const Pose& X_WT);
  /// Removes the level set that MakeTool() made, with openvdb::tools::csgDifference(). The bone is not pruned, which
  /// also saves time.
  void RemoveTool();
  /// Removes the tool from the bone's own leaves near it, without a level set of the tool.
  void CutLeaves(const Tool& tool, const Pose& X_WT);

  const Bone& bone() const { return bone_; }

 private:
  struct Grid;
  Bone bone_;
  std::unique_ptr<Grid> tool_;
};

}  // namespace kerf
