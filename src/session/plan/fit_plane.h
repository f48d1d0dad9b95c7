// Plane of a cut: the position of the kerf, from the bone before and after.
#pragma once

#include <optional>

#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

/// Mid-plane of a kerf.
struct FittedPlane {
  Vec3 p_W_mm{0};          // centre of the kerf, on the plane
  Vec3 normal_W{0, 0, 1};  // unit length; largest component positive, or on the side of `near`'s normal
  double rms_mm = 0;       // root mean square distance of the kerf's midpoints from the plane
  double width_mm = 0;     // median width of the kerf
  double volume_mm3 = 0;   // removed bone within the search region
  double length_mm = 0;    // longer extent of the kerf in the plane
  double depth_mm = 0;     // shorter extent
  Vec3 depth_W{0, 0, -1};  // direction of the shorter extent, unit length: to the side where the kerf ends in bone;
                           // downwards if the cut goes through
  int middles = 0;         // number of places with both sides of the kerf; 0: fitted to the removed volume only
};

/// Search region for a kerf. By default the whole bone.
struct KerfSearch {
  std::optional<Box3> within;    // world frame
  std::optional<CutPlane> near;  // use only bone removed near this plane:
  double reach_mm = 5;           // maximum distance from it
  double max_tilt_deg = 30;      // maximum angle to it
};

/// Fits the mid-plane of the kerf. Returns none if no bone was removed or if the removed bone has no plane: fewer than
/// three places, or a shape as thick as wide. If there are several kerfs, returns the one near most of the removed
/// bone.
///
/// The fit starts from the plane near most of the changed voxels. On lines across it, the midpoints between the two
/// sides of the kerf are found; the result is the least-squares plane through them, except the tenth furthest from it.
/// The sides are searched 1.25 voxels inside the bone, so that kerfs thinner than a voxel are also found. If there
/// are no places with bone on both sides, as for a shaving, the result is the plane of the removed volume's moments.
std::optional<FittedPlane> FitKerf(const Bone& before, const Bone& after, const KerfSearch& search);
std::optional<FittedPlane> FitKerf(const Bone& before, const Bone& after, std::optional<Box3> within = {});

}  // namespace kerf
