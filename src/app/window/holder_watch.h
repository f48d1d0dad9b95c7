// Whether what holds the saw, which the simulation does not know, is inside the bone.
#pragma once

#include <vector>

#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf {

/// Detects that the hub of a disc or the handpiece is inside a bone. Either one counts as inside from half the bone's
/// band (see Bone::band_mm()) below the surface on, until it is out of the bone.
class HolderWatch {
 public:
  /// Throws Error for an invalid tool.
  void SetTool(const Tool& tool);
  /// `X_WT`: pose of the tool. A call takes about 10 us.
  void Update(const Bone& bone, const Pose& X_WT);
  bool hub_in_bone() const { return hub_.in_bone; }
  bool handpiece_in_bone() const { return handpiece_.in_bone; }

 private:
  struct Part {
    std::vector<Vec3> points_T;  // on its surface
    bool in_bone = false;

    void Update(const Bone& bone, const Pose& X_WT);
  };
  Part hub_;
  Part handpiece_;
};

}  // namespace kerf
