// How the built-in paths are put together.
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

/// The disc upright in a frame B, its spindle along y, its feed in the x-z plane.
struct UprightMotion {
  Way x_mm;
  Way depth_mm;  // of the rim's lowest point below z = 0
  Way y_mm;      // along the spindle
  Way tilt_rad;  // about x through the disc's middle
};
Pose CalcUprightPose(const UprightMotion& motion, const DiscSaw& saw, double t_s);

/// A bone that is made again and again keeps the last one made: copying is cheaper. Any thread.
std::function<Bone(double, int)> RememberLast(std::function<Bone(double voxel_mm, int band_voxels)> make);

/// The solid of a formula: regions from `region`, constants from `materials`.
ExactSolid MakeSolid(std::function<double(const Vec3&)> distance_mm, std::function<int(const Vec3&)> region,
                     const MaterialTable& materials);

/// Name, title, saw, materials and both holdings of a path; the rest is the caller's.
StudyPath MakePlainPath(const std::string& name, const std::string& title);

/// The part of a bone within a box of frame B; the box's faces are cut.
struct BonePart {
  Pose X_WB;
  Box3 box_B;

  double Distance(const Vec3& p_W) const;
  Box3 CalcBounds() const;
};

/// Solid, bounds and maker of a block, less where `cavity`, a distance of the air's side, is above that of the block.
void SetBlock(StudyPath& path, const BlockParams& block, const std::function<double(const Vec3&)>& cavity = nullptr);
/// Solid, bounds and maker of the generic mandible, of all of it or of a part.
void SetMandible(StudyPath& path, const std::shared_ptr<const MandibleShape>& shape,
                 const std::optional<BonePart>& part);
/// The same of an imported bone, which is the truth: trilinear between its voxels. With its materials and, where it has
/// CT numbers and a law is given, with E from those in cancellous bone.
void SetImported(StudyPath& path, Bone truth, const std::optional<BonePart>& part, const std::optional<CtLaw>& law);

/// By name; none when there is no such path.
std::optional<StudyPath> MakeBlockPath(const std::string& name);
StudyPath MakeMandiblePath();
/// Throws Error with the reason when its data are not there.
StudyPath MakeCtPath(const std::string& data_folder, const std::string& cache_folder);

}  // namespace kerf
