// How two pieces lie to each other: the volume in which both are, and the gap between them.
#pragma once

#include <vector>

#include "bone/pieces/surface_tree.h"
#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

/// Volume that lies in both bones, mm^3, a at X_WA and b at X_WB. Space is divided into blocks that lie in both, or not
/// in both, by their middle's distances, and the rest into cells of half a voxel (an eighth where both surfaces are in
/// the cell), in which the larger of both distances is linear on tetrahedra. The error is that of the bones' own
/// surfaces, second order in the voxel: below 2 % of overlaps two voxels thick and more.
double CalcOverlap(const Bone& a, const Pose& X_WA, const Bone& b, const Pose& X_WB);
/// The same of bones whose bounds are known: looking for these takes longer than the overlap.
struct BoneInBox {
  const Bone* bone;
  Box3 bounds;  // of its surface, to a voxel; empty: there is none
};
double CalcOverlap(const BoneInBox& a, const Pose& X_WA, const BoneInBox& b, const Pose& X_WB);

/// Between two surfaces that do not overlap.
struct Gap {
  double gap_mm = 0;  // the least
  Vec3 p_WA_mm{0};    // where: on the one
  Vec3 p_WB_mm{0};    // and on the other
};
/// A surface with its hierarchy.
struct SurfaceInTree {
  const TriangleMesh* mesh;
  const SurfaceTree* tree;
};
/// From each point of either surface to the nearest triangle of the other; what two edges have between them is not
/// looked at (below a tenth of the triangles' size). None when nothing is nearer than `limit_mm`.
std::optional<Gap> CalcGap(const SurfaceInTree& a, const Pose& X_WA, const SurfaceInTree& b, const Pose& X_WB,
                           double limit_mm);

/// Of the part of surface a that faces surface b: from its points the nearest point of b is within `reach_mm` and less
/// than 45 degrees off the normal.
struct Facing {
  double area_mm2 = 0;     // of a
  double mean_mm = 0;      // gap
  double p95_mm = 0;       // 95 % of the area are nearer
  double contact_mm2 = 0;  // of a, nearer than `contact_mm`
};
Facing CalcFacing(const SurfaceInTree& a, const Pose& X_WA, const SurfaceInTree& b, const Pose& X_WB, double reach_mm,
                  double contact_mm);

}  // namespace kerf
