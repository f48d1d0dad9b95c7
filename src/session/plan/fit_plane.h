// The plane that was cut: where the kerf lies, from the bone before and after.
#pragma once

#include <optional>

#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

/// The mid-plane of a kerf.
struct FittedPlane {
  Vec3 p_W_mm{0};          // middle of the kerf, on the plane
  Vec3 normal_W{0, 0, 1};  // unit length; its larger component is positive, or it is on the side of `near`'s normal
  double rms_mm = 0;       // of the kerf's middles about the plane
  double width_mm = 0;     // of the kerf, the median
  double volume_mm3 = 0;   // that left the bone within the search
  double length_mm = 0;    // of the kerf in the plane, the longer way and
  double depth_mm = 0;     // the shorter way
  Vec3 depth_W{0, 0, -1};  // the shorter way, unit length: to the side where the kerf ends in bone; of a cut through
                           // and through, downwards
  int middles = 0;         // places where both sides of the kerf were found; 0: fitted to the lost volume alone
};

/// Where a kerf is looked for. All of the bone, when nothing is given.
struct KerfSearch {
  std::optional<Box3> within;    // world
  std::optional<CutPlane> near;  // only what was lost near this plane counts:
  double reach_mm = 5;           // so far from it at most
  double most_tilt_deg = 30;     // and so far turned
};

/// None where nothing was lost, or what was lost has no plane: fewer than three places, or a shape as thick as wide.
/// Where several kerfs were cut the one is found that most of the loss lies near.
///
/// First the plane that most of the changed voxels lie near, then, on lines across it, the middle between both sides of
/// the kerf, and the plane with the least squares of distances to them, without the tenth that is off. The sides are
/// looked for 1.25 voxels within the bone, so that kerfs thinner than a voxel are found as well. Where nowhere both
/// sides are bone, as for a shaving, it is the plane of the lost volume's moments.
std::optional<FittedPlane> FitKerf(const Bone& before, const Bone& after, const KerfSearch& search);
std::optional<FittedPlane> FitKerf(const Bone& before, const Bone& after, std::optional<Box3> within = {});

}  // namespace kerf
