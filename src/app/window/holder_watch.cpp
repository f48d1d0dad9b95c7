#include "app/window/holder_watch.h"

#include <algorithm>

#include "view/picture/handpiece.h"
#include "view/picture/picture.h"

namespace kerf {

void HolderWatch::SetTool(const Tool& tool) {
  constexpr double kStep_mm = 4;
  hub_ = {.points_T = SampleHub(tool)};
  handpiece_ = {.points_T = SampleHandpiece(tool, kStep_mm)};
}

void HolderWatch::Update(const Bone& bone, const Pose& X_WT) {
  hub_.Update(bone, X_WT);
  handpiece_.Update(bone, X_WT);
}

void HolderWatch::Part::Update(const Bone& bone, const Pose& X_WT) {
  const double limit_mm = in_bone ? 0 : -0.5 * bone.band_mm();
  in_bone = std::any_of(points_T.begin(), points_T.end(),
                        [&](const Vec3& p_T) { return bone.SignedDistance(X_WT.Point(p_T)) < limit_mm; });
}

}  // namespace kerf
