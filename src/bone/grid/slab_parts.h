// Division of a bone into the three parts of the paper: a thin slice about a plane, and the bone to its left and right.
#pragma once

#include <functional>
#include <optional>

#include "kerf/bone.h"

namespace kerf {

struct SlabCut {
  CutPlane plane;
  double thickness_mm = 0.25;  // of the slice
  /// A plane may pass through a bone in several places, for example through both sides of a mandible. If false, the
  /// bone is cut at the place nearest to `near_W` (by default the plane's point), and at further places, nearest first,
  /// only while they still connect the two sides. If true, the plane cuts at all places.
  bool everywhere = false;
  std::optional<Vec3> near_W;
};

template <typename V>
void Describe(SlabCut& p, V&& visit) {
  visit("thickness_mm", p.thickness_mm, Range{0.02, 50}, "thickness of the slice");
}

struct SlabParts {
  Bone left;   // s < -t/2, with s the distance from the plane along its normal and t the thickness
  Bone slice;  // |s| < t/2
  Bone right;  // s > t/2
  /// The slice's surface on a separate lattice along the plane: closed, outward-oriented, with flat faces for any
  /// thickness. It has far fewer triangles than ExtractSurface(slice) and should be used instead.
  TriangleMesh slice_surface_W;
  std::size_t places = 0;      // number of places where the plane passes through the bone
  std::size_t cut_places = 0;  // number of places that are cut
  double distance_mm = 0;      // from the chosen point to the nearest place, accurate to about a voxel
};

/// Divides a bone into three parts. They do not overlap and fill the whole bone, except for the effect of the voxels
/// along the edges of the cut: at each segment's rim a cross-section of less than h^2 / (2 sin a) is lost, where h is
/// the voxel size and a the angle between the plane and the bone's surface. Bone that the plane crosses but does not
/// cut stays with the segment that it is joined to. Bone joined to neither segment goes to the side on which most of it
/// lies.
///
/// The segments have the bone's voxels. The slice has finer ones, which divide the bone's evenly: at most half their
/// edge and at most a quarter of the slice's thickness, so that its faces are planes to float precision. (Within the
/// slice phi is |s| - t/2, with a kink at the plane. Linear interpolation places a face correctly if no edge that
/// crosses it reaches beyond the kink: the diagonal of a voxel, sqrt(3) h, must be less than t/2.) On the finer grid
/// phi is interpolated linearly on the tetrahedra of cell_volume.h, which a finer grid of the same kind only
/// subdivides. Therefore the slice has the bone's own surface, and resampling neither adds nor loses volume.
///
/// Regions, materials and notes are those of the bone. Reversing the normal swaps left and right, bit for bit. Throws
/// kerf::Error if a value is out of range, the plane misses the bone, or a part would be empty.
SlabParts MakeSlabParts(const Bone& bone, const SlabCut& cut);

}  // namespace kerf
