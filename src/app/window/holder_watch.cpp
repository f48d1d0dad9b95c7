#include "app/window/holder_watch.h"

#include <algorithm>

#include "cut/tool/looks.h"
#include "view/picture/handpiece.h"

namespace kerf {

void HolderWatch::SetTool(const Tool& tool) {
  constexpr double kStep_mm = 4;
  hub_ = {.points_T = MakeToolLooks(tool).hub};
  handpiece_ = {.points_T = SampleHandpiece(tool, kStep_mm)};
  places_ = {};
}

void HolderWatch::Update(const Bone& bone, const Pose& X_WT) {
  hub_.Update(bone, X_WT);
  handpiece_.Update(bone, X_WT);
}

void HolderWatch::NoteCut() {
  if (!places_.hub_W) places_.hub_W = hub_.place_W;
  if (!places_.handpiece_W) places_.handpiece_W = handpiece_.place_W;
}

void HolderWatch::Part::Update(const Bone& bone, const Pose& X_WT) {
  const double limit_mm = place_W ? 0 : -0.5 * bone.band_mm();
  const auto found = std::find_if(points_T.begin(), points_T.end(),
                                  [&](const Vec3& p_T) { return bone.SignedDistance(X_WT.Point(p_T)) < limit_mm; });
  place_W = found == points_T.end() ? std::nullopt : std::optional(X_WT.Point(*found));
}

}  // namespace kerf
