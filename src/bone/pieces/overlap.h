// Relation between two pieces: the volume of their overlap, and the gap between them.
#pragma once

#include <vector>

#include "bone/pieces/surface_tree.h"
#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

/// Returns the volume that lies in both bones, mm^3, with `a` at X_WA and `b` at X_WB. Space is divided into blocks.
/// The distances at the centre of a block show whether it lies entirely in both bones or entirely outside their
/// overlap. The other blocks are divided into cells of half a voxel (an eighth where both surfaces are in the cell), in
/// which the larger of the two distances is linear on tetrahedra. The error is that of the bones' surfaces,
/// second-order in the voxel size: below 2 % for overlaps at least two voxels thick.
double CalcOverlap(const Bone& a, const Pose& X_WA, const Bone& b, const Pose& X_WB);
/// A bone with its bounds, for the overload below: computing the bounds takes longer than computing the overlap.
struct BoneWithBounds {
  const Bone* bone;
  Box3 bounds;  // of its surface, to a voxel; empty if there is none
};
double CalcOverlap(const BoneWithBounds& a, const Pose& X_WA, const BoneWithBounds& b, const Pose& X_WB);

/// Gap between two surfaces that do not overlap.
struct Gap {
  double gap_mm = 0;  // minimum distance
  Vec3 p_WA_mm{0};    // its end on surface a
  Vec3 p_WB_mm{0};    // its end on surface b
};
/// A surface with its search tree.
struct SurfaceWithTree {
  const TriangleMesh* mesh;
  const SurfaceTree* tree;
};
/// Returns the minimum distance from the points of either surface to the triangles of the other. Distances between two
/// edges are not considered (error below a tenth of the triangles' size). Empty if nothing is nearer than `limit_mm`.
std::optional<Gap> CalcGap(const SurfaceWithTree& a, const Pose& X_WA, const SurfaceWithTree& b, const Pose& X_WB,
                           double limit_mm);

/// Statistics of the part of surface a that faces surface b. A point of a faces b if the nearest point of b is within
/// `reach_mm` and in a direction less than 45 degrees from the normal.
struct Facing {
  double area_mm2 = 0;     // of a
  double mean_mm = 0;      // gap
  double p95_mm = 0;       // gap that 95 % of the area does not exceed
  double contact_mm2 = 0;  // area of a with a gap below `contact_mm`
};
Facing CalcFacing(const SurfaceWithTree& a, const Pose& X_WA, const SurfaceWithTree& b, const Pose& X_WB,
                  double reach_mm, double contact_mm);

}  // namespace kerf
