// Building blocks of the built-in paths.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "bone/grid/build.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "experiment/study/case.h"
#include "experiment/study/way.h"

namespace kerf {

/// Motion of an upright disc in a frame B, with its spindle along y and its feed in the x-z plane.
struct UprightMotion {
  Way x_mm;
  Way depth_mm;  // of the rim's lowest point below z = 0
  Way y_mm;      // along the spindle
  Way tilt_rad;  // about x through the disc's centre
};
Pose CalcUprightPose(const UprightMotion& motion, const DiscSaw& saw, double t_s);

/// Caches the last bone that `make` returned, since copying it is cheaper than making it again. Thread-safe.
std::function<Bone(double, int)> RememberLast(std::function<Bone(double voxel_mm, int band_voxels)> make);

/// Makes a solid from a formula: regions from `region`, constants from `materials`.
ExactSolid MakeSolid(std::function<double(const Vec3&)> distance_mm, std::function<int(const Vec3&)> region,
                     const MaterialTable& materials);

/// Returns a path with name, title, saw, materials and both holdings; the caller sets the rest.
StudyPath MakePlainPath(const std::string& name, const std::string& title);

/// The part of a bone within a box of frame B, with cut faces on the box.
struct BonePart {
  Pose X_WB;
  Box3 box_B;

  double Distance(const Vec3& p_W) const;
  Box3 CalcBounds() const;
};

/// Sets solid, bounds and bone maker of a block. `cavity` is a signed distance that is positive inside a cavity, where
/// there is no bone; the solid's distance is the maximum of the two.
void SetBlock(StudyPath& path, const BlockParams& block, const std::function<double(const Vec3&)>& cavity = nullptr);
/// Sets solid, bounds and bone maker of the generic mandible, whole or a part of it.
void SetMandible(StudyPath& path, const std::shared_ptr<const MandibleShape>& shape,
                 const std::optional<BonePart>& part);
/// The same for an imported bone, which serves as the exact solid, with trilinear interpolation between its voxels.
/// Includes its materials and, if it has CT numbers and a law is given, E from the CT in cancellous bone.
void SetImported(StudyPath& path, Bone truth, const std::optional<BonePart>& part, const std::optional<CtLaw>& law);

/// Returns the path of that name, or nullopt if there is none.
std::optional<StudyPath> MakeBlockPath(const std::string& name);
StudyPath MakeMandiblePath();
/// Throws Error with the reason if its data are missing.
StudyPath MakeCtPath(const std::string& data_folder, const std::string& cache_folder);

}  // namespace kerf
