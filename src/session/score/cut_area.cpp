#include "session/score/cut_area.h"

#include <algorithm>
#include <cmath>

#include "bone/grid/removed.h"
#include "session/score/columns.h"

namespace kerf {
namespace {

constexpr double kLeastAreaStep_mm = 0.1;

/// Returns the width of the wanted cut at a place of its plane.
double CalcWidth(const WantedCut& cut, double s_mm, double t_mm) {
  if (!cut.solid) return cut.thickness_mm;
  const double z_mm = std::clamp(cut.depth_mm - t_mm, 0.0, cut.solid->top_z_mm);  // above the tip
  double radius_mm = cut.solid->top_radius_mm;
  for (const RoundSolid::Face& face : cut.solid->CalcFaces()) {
    if (face.r > 0) radius_mm = std::min(radius_mm, (face.offset_mm - face.z * z_mm) / face.r);
  }
  const double beyond_mm = s_mm - std::clamp(s_mm, 0.0, cut.length_mm);
  return 2 * std::sqrt(std::max(0.0, radius_mm * radius_mm - beyond_mm * beyond_mm));
}

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
  double width_sum = 0;
  long made = 0;
  Vec3 sum_W{0};
  for (double s_mm = -cut.radius_mm + 0.5 * step_mm; s_mm < cut.length_mm + cut.radius_mm; s_mm += step_mm) {
    for (double t_mm = -kAbove_mm + 0.5 * step_mm; t_mm < cut.depth_mm; t_mm += step_mm) {
      const Vec3 p_W = cut.ToWorld({s_mm, t_mm, 0});
      if (cut.CalcDistance(p_W) >= 0 || phi_before.Calc(p_W) >= 0) continue;
      ++bone;
      width_sum += CalcWidth(cut, s_mm, t_mm);
      sum_W += p_W;
      if (is_cut(s_mm, t_mm)) ++made;
    }
  }
  const double sample_mm2 = step_mm * step_mm;
  CutArea area{.bone_mm2 = static_cast<double>(bone) * sample_mm2,
               .cut_mm2 = static_cast<double>(made) * sample_mm2,
               .bone_mm3 = width_sum * sample_mm2,
               .middle_W = cut.start_W};
  if (bone > 0) area.middle_W = sum_W / static_cast<double>(bone);
  return area;
}

}  // namespace kerf
