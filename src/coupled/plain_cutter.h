// Stand-in until the field's own cutter is there.
#pragma once
#include <algorithm>
#include "bone/field.h"
#include "removal/sweep.h"
namespace kerf {
class PlainCutter {
 public:
  PlainCutter(BoneField& field, const Tool& tool) : field_(field), saw_(std::get<DiscSaw>(tool)) {}
  struct Result {
    double removed_mm3 = 0;
    bool out_of_leaves = false;
  };
  Result Cut(const Pose& X_from, const Pose& X_to) {
    Result result;
    const DiscSweep sweep = MakeDiscSweep(saw_, X_from, X_to);
    const double h = field_.voxel_mm(), band = field_.band_mm();
    const Vec3 n = X_to.Vector({0, 0, 1});
    Vec3 half = (saw_.radius_mm() + band) * glm::sqrt(glm::max(Vec3(0), 1.0 - n * n)) +
                (saw_.thickness_mm + band) * glm::abs(n);
    Box3 box;
    for (const Vec3& c : {X_from.p_AB, X_to.p_AB}) {
      box.Include(c - half);
      box.Include(c + half);
    }
    const auto down = [&](double x) { return static_cast<int>(std::floor(x / h)) >> 3; };
    for (int x = down(box.lower.x); x <= down(box.upper.x); ++x)
      for (int y = down(box.lower.y); y <= down(box.upper.y); ++y)
        for (int z = down(box.lower.z); z <= down(box.upper.z); ++z) {
          const LeafIndex leaf{x, y, z};
          if (field_.kind(leaf) == BoneField::LeafKind::kOutside) continue;
          const Vec3 mid_T = X_to.InversePoint(h * (Vec3(8 * x, 8 * y, 8 * z) + 3.5));
          if (sweep.Distance(mid_T.x, mid_T.y, mid_T.z) > band + 6.1 * h) continue;
          if (std::hypot(mid_T.x, mid_T.y) < saw_.radius_mm() - (3 + 6.1) * h) continue;
          const float* old = field_.Read(leaf);
          float* out = nullptr;
          for (int i = 0; i < 512; ++i) {
            const Vec3 p = X_to.InversePoint(h * Vec3(8 * x + (i >> 6), 8 * y + ((i >> 3) & 7), 8 * z + (i & 7)));
            if (std::hypot(p.x, p.y) < saw_.radius_mm() - 3 * h) continue;
            const float v = static_cast<float>(std::min(-sweep.Distance(p.x, p.y, p.z), band));
            if (!(v > old[i])) continue;
            if (!out) {
              out = field_.Write(leaf);
              if (!out) {
                result.out_of_leaves = true;
                break;
              }
              old = out;
            }
            const auto occ = [&](float f) { return std::clamp(0.5 - static_cast<double>(f) / h, 0.0, 1.0); };
            result.removed_mm3 += (occ(out[i]) - occ(v)) * h * h * h;
            out[i] = v;
          }
        }
    return result;
  }
  void Lift() {}
  std::array<double, 256> CalcRemovedByRegion() { return {}; }

 private:
  BoneField& field_;
  DiscSaw saw_;
};
inline Pose Interpolate(const Pose& a, const Pose& b, double t) {
  Pose X;
  X.R_AB = glm::normalize(glm::slerp(a.R_AB, b.R_AB, t));
  X.p_AB = a.p_AB + t * (b.p_AB - a.p_AB);
  return X;
}
}  // namespace kerf
