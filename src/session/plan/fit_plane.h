// Finds the plane of a cut from the bone before and after it.
#pragma once

#include <functional>
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
  int midpoints = 0;       // number of midpoints between the kerf's sides; 0: fitted to the removed volume only
};

/// Search region for a kerf; by default, the whole bone.
struct KerfSearch {
  std::optional<Box3> within;    // world frame
  std::optional<CutPlane> near;  // use only bone removed near this plane:
  double reach_mm = 5;           // maximum distance from it
  double max_tilt_deg = 30;      // maximum angle to it
  /// Returns false where removed bone belongs to another cut. Null: all of it belongs to this one.
  std::function<bool(const Vec3& p_W)> belongs;
};

/// Why no plane was fitted: the removed bone is not flat enough.
struct NoKerf {
  double removed_mm3 = 0;      // within the search region
  double extents_mm[3] = {};   // of the removed bone as a block with its moments, the longest first; 0: too few voxels
  double least_second_mm = 0;  // what the second extent must be, with such a third one
};

/// Fits the mid-plane of the kerf. Returns none if no bone was removed or if no plane can be fitted to the removed bone
/// because it covers too few voxels or is hardly wider than it is thick. If there are several kerfs, returns the
/// plane of the one with the most removed bone.
///
/// The fit starts from the plane with the most changed voxels near it. On lines across it, the midpoints between the
/// two sides of the kerf are found; the result is the least-squares plane through them, without the 10 % that are
/// furthest from it. The sides are located 1.25 voxels inside the bone, so that kerfs thinner than a voxel are also
/// found. If there is no place with bone on both sides, as when the bone was only shaved, the plane is computed from
/// the moments of the removed volume. `why` (optional) is set if none is returned.
std::optional<FittedPlane> FitKerf(const Bone& before, const Bone& after, const KerfSearch& search,
                                   NoKerf* why = nullptr);
std::optional<FittedPlane> FitKerf(const Bone& before, const Bone& after, std::optional<Box3> within = {});

}  // namespace kerf
