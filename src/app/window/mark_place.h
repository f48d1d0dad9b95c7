// Where a marked point lies.
#pragma once

#include <cstdint>
#include <functional>

#include "kerf/bone.h"
#include "session/marks/mark.h"
#include "view/live/slice_view.h"

namespace kerf {

enum class MarkPlace : std::uint8_t { kUsual, kInAir, kFarFromBone };

inline constexpr double kMarkFar_mm = 2;  // from the bone
inline constexpr double kMarkAir_HU = -400;

/// Finds out whether a point lies where such a structure can hardly be. A nerve may lie in soft tissue, which only a CT
/// tells from air. `ct`: the CT of the bone; empty: none.
inline MarkPlace FindMarkPlace(const Bone& bone, const CtSource& ct, MarkKind kind, const Vec3& p_W) {
  if (ct && ct(p_W) < kMarkAir_HU) return MarkPlace::kInAir;
  if (ct && IsNerve(kind)) return MarkPlace::kUsual;
  constexpr int kSteps = 5;  // the level set does not tell distances of 2 mm
  for (int k = -kSteps; k <= kSteps; ++k) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      for (int i = -kSteps; i <= kSteps; ++i) {
        if (i * i + j * j + k * k > kSteps * kSteps) continue;
        if (bone.SignedDistance(p_W + kMarkFar_mm / kSteps * Vec3(i, j, k)) <= 0) return MarkPlace::kUsual;
      }
    }
  }
  return MarkPlace::kFarFromBone;
}

}  // namespace kerf
