#include "session/score/cut_area.h"

#include <algorithm>
#include <cmath>

#include "bone/grid/removed.h"
#include "session/score/columns.h"

namespace kerf {
namespace {

constexpr double kLeastAreaStep_mm = 0.1;

}  // namespace

CutArea CalcCutArea(const Bone& before, const Bone& now, const WantedCut& cut) {
  const PhiSampler phi_before(before);
  const PhiSampler phi_now(now);
  const double step_mm = std::max(0.5 * before.voxel_mm(), kLeastAreaStep_mm);
  const double beside_mm = cut.margin_mm + 0.5 * cut.thickness_mm;
  const int beside = static_cast<int>(beside_mm / before.voxel_mm());
  // Looks first where the kerf should be.
  const auto is_cut = [&](double s_mm, double t_mm) {
    for (int i = 0; i <= 2 * beside; ++i) {
      const double w_mm = before.voxel_mm() * (i % 2 == 0 ? i / 2 : -(i + 1) / 2);
      const Vec3 p_W = cut.ToWorld({s_mm, t_mm, w_mm});
      if (phi_now.Calc(p_W) >= 0 && phi_before.Calc(p_W) < 0) return true;
    }
    return false;
  };
  long bone = 0;
  long made = 0;
  Vec3 sum_W{0};
  for (double s_mm = -cut.radius_mm + 0.5 * step_mm; s_mm < cut.length_mm + cut.radius_mm; s_mm += step_mm) {
    for (double t_mm = -kAbove_mm + 0.5 * step_mm; t_mm < cut.depth_mm; t_mm += step_mm) {
      const Vec3 p_W = cut.ToWorld({s_mm, t_mm, 0});
      if (cut.CalcDistance(p_W) >= 0 || phi_before.Calc(p_W) >= 0) continue;
      ++bone;
      sum_W += p_W;
      if (is_cut(s_mm, t_mm)) ++made;
    }
  }
  CutArea area{static_cast<double>(bone) * step_mm * step_mm, static_cast<double>(made) * step_mm * step_mm,
               cut.start_W};
  if (bone > 0) area.middle_W = sum_W / static_cast<double>(bone);
  return area;
}

}  // namespace kerf
