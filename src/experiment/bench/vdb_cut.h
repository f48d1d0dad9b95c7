// Cutting as one would with OpenVDB alone: a new level set of the tool in every tick, and the library's difference.
#pragma once

#include <memory>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// A bone that is cut by the library. One thread.
class VdbCut {
 public:
  /// Works on a copy.
  explicit VdbCut(Bone bone);
  ~VdbCut();

  /// Makes a level set of the tool where it is, of the bone's voxels and band, by filling the leaves at its surface in
  /// single precision, and takes it away by openvdb::tools::csgDifference(). The library's own makers of level sets (of
  /// spheres, of meshes) take longer. The bone is left unpruned, which is the quicker way too.
  void Cut(const Tool& tool, const Pose& X_WT);

  const Bone& bone() const { return bone_; }

 private:
  Bone bone_;
};

}  // namespace kerf
