// Places where a plane passes through a bone, and the choice of those that a cut must sever.
#pragma once

#include <vector>

#include "bone/grid/labels.h"

namespace kerf {

/// Signed distance of a voxel's centre from a plane, mm. Reversing the normal changes only the sign.
struct PlaneDistance {
  Vec3 p_W;
  Vec3 normal_W;  // unit length
  double voxel_mm;

  double operator()(const openvdb::Coord& c) const { return At(Vec3(c.x(), c.y(), c.z())); }
  double At(const Vec3& p_vox) const {
    const Vec3 d = voxel_mm * p_vox - p_W;
    return normal_W.x * d.x + normal_W.y * d.y + normal_W.z * d.z;
  }
};

/// Bone within `reach_mm` of the plane (kNear), or beyond it on either side.
enum class PlaneSide { kLeft, kNear, kRight };
inline PlaneSide SideOf(double distance_mm, double reach_mm) {
  if (distance_mm < -reach_mm) return PlaneSide::kLeft;
  return distance_mm > reach_mm ? PlaneSide::kRight : PlaneSide::kNear;
}

/// Assignment of a part of a block.
enum class PartFate : char { kLeft, kRight, kCut };  // kCut: to be divided by the plane

struct Section {
  std::vector<PartFate> fates;  // by node
  std::size_t places = 0;       // number of places where the plane passes through the bone, with bone beyond the
                                // reach on both sides
  std::size_t cut_places = 0;   // number of them that are cut
  double distance_mm = 0;       // from the chosen point to the nearest of them, accurate to about a voxel
  bool everywhere = false;      // true if the plane touches no bone that is not cut
};

/// Chooses the place nearest to `near_W`, and further places, nearest first, while other bone still connects the two
/// sides. Bone that is joined to neither side goes to the side on which most of it lies. `labels` must have been
/// classified by SideOf() with `reach_mm`, which must be larger than half the thickness and at least one voxel. If
/// there is no place, `places` is 0 and nothing is cut.
Section ChooseSection(const Labels& labels, const PlaneDistance& distance, double reach_mm, double half_thickness_mm,
                      const Vec3& near_W);

}  // namespace kerf
