// The paper's three parts of a bone: a thin slice about a plane, and what is left of it and right of it.
#pragma once

#include <functional>
#include <optional>

#include "kerf/bone.h"

namespace kerf {

struct SlabCut {
  CutPlane plane;
  double thickness_mm = 0.25;  // of the slice; 0.02 to 50
  /// A plane may go through a bone in several places: through both sides of a mandible, say. False: the bone is cut
  /// where the plane goes through it nearest to `near_W` (else to the plane's point), and in further places, nearest
  /// first, only as long as they still hold the two sides together. True: the plane cuts all that it meets.
  bool everywhere = false;
  std::optional<Vec3> near_W;
};

struct SlabParts {
  Bone left;   // s < -t/2, with s the distance from the plane along its normal and t the thickness
  Bone slice;  // |s| < t/2
  Bone right;  // s > t/2
  /// The slice's surface on a lattice of its own along the plane: closed, outward, with plane faces however thin. Of
  /// far fewer triangles than ExtractSurface(slice), and the one to use.
  TriangleMesh slice_surface_W;
  std::size_t places = 0;      // where the plane goes through the bone
  std::size_t cut_places = 0;  // of them
  double distance_mm = 0;      // from the chosen point to the nearest place, to about a voxel
};

/// The three parts lie in each other's way nowhere and fill the whole, up to what voxels round off along the edges of
/// the cut: of each segment's rim less than h^2 / (2 sin a) of cross-section, with voxels of h and the plane at an
/// angle a to the bone's surface. Bone that the plane crosses but doesn't cut stays with the segment that it's joined
/// to; a bit joined to neither goes to the side that most of it is on.
///
/// The segments have the bone's voxels, the slice finer ones that divide the bone's evenly, of at most half of theirs
/// and a quarter of its thickness, so that its faces are planes to the precision of a float. (Within the slice phi is
/// |s| - t/2, with a kink at the plane. Linear interpolation places a face truly when no edge that crosses it reaches
/// beyond the kink: the diagonal of a voxel, sqrt(3) h, must be less than t/2.) On the finer grid phi is interpolated
/// linearly on the tetrahedra of cell_volume.h, which a finer grid of the same kind only subdivides: the slice has the
/// bone's own surface, and no volume is gained or lost by resampling.
///
/// Regions, materials and notes are those of the bone. Turning the normal round swaps left and right, bit for bit.
/// Throws Error when a value is out of range, the plane misses the bone, or a part would be empty.
SlabParts MakeSlabParts(const Bone& bone, const SlabCut& cut);

}  // namespace kerf
