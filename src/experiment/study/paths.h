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
  Way depth_mm;  // depth of the rim's lowest point below z = 0
  Way y_mm;      // along the spindle
  Way tilt_rad;  // about x through the disc's centre
};
Pose CalcUprightPose(const UprightMotion& motion, const DiscSaw& saw, double t_s);

/// Returns a function that does the same as `make` but keeps a copy of the last bone, since copying a bone is cheaper
/// than making it again. The returned function is thread-safe.
std::function<Bone(double, int)> RememberLast(std::function<Bone(double voxel_mm, int band_voxels)> make);

/// Makes a solid from a formula for its distance, with the regions from `region` and their elastic constants from
/// `materials`.
ExactSolid MakeSolid(std::function<double(const Vec3&)> distance_mm, std::function<int(const Vec3&)> region,
                     const MaterialTable& materials);

/// Returns a path with name, title, saw, materials and both holdings; the caller sets the rest.
StudyPath MakePlainPath(const std::string& name, const std::string& title);

/// The part of a bone inside a box in frame B. Its cut faces lie on the box.
struct BonePart {
  Pose X_WB;
  Box3 box_B;

  double Distance(const Vec3& p_W) const;
  Box3 CalcBounds() const;
};

/// What is missing in a block: signed distances that are positive where there is no bone; null: nothing. The solid's
/// distance is the maximum of all.
struct BlockGaps {
  std::function<double(const Vec3&)> shape;    // the bone was never there
  std::function<double(const Vec3&)> was_cut;  // a saw has removed it
};
/// Sets the solid, the bounds and the bone maker of `path` to those of a block.
void SetBlock(StudyPath& path, const BlockParams& block, const BlockGaps& gaps = {});
/// Sets the solid, the bounds and the bone maker of `path` to those of the generic mandible or a part of it.
void SetMandible(StudyPath& path, const std::shared_ptr<const MandibleShape>& shape,
                 const std::optional<BonePart>& part);
/// Does the same for an imported bone, which itself serves as the exact solid, with trilinear interpolation between its
/// voxels. Also sets the materials and, if the bone has CT numbers and a law is given, E from the CT in cancellous
/// bone.
void SetImported(StudyPath& path, Bone truth, const std::optional<BonePart>& part, const std::optional<CtLaw>& law);

/// Returns the path of that name, or nullopt if there is none.
std::optional<StudyPath> MakeBlockPath(const std::string& name);
StudyPath MakeMandiblePath();
/// Throws Error with the reason if its data are missing.
StudyPath MakeCtPath(const std::string& data_folder, const std::string& cache_folder);

}  // namespace kerf
