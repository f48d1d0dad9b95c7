// The built-in paths in bones other than blocks: the generic mandible, and one from a CT.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "base/files/files.h"
#include "bone/grid/crop.h"
#include "bone/grid/ct_modulus.h"
#include "bone/import/import.h"
#include "bone/material/ct_law_table.h"
#include "bone/models/mandible.h"
#include "bone/vdb/bonefile.h"
#include "experiment/study/paths.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Returns the orientation of B with y along `along` and z as close to `out` as possible, rotated by a few more
/// degrees.
Quat StandOn(const Vec3& along, const Vec3& out) {
  const Vec3 y = glm::normalize(along);
  const Vec3 z = glm::normalize(out - glm::dot(out, y) * y);
  const Quat R_W = glm::normalize(glm::quat_cast(glm::dmat3(glm::cross(y, z), y, z)));
  return glm::normalize(R_W * glm::angleAxis(0.07, glm::normalize(Vec3(1, 0.6, 0.3))));
}

/// Lowers the disc, whose centre is above B's origin, until its rim touches the bone. Returns the depth (mm) of the
/// rim's lowest point below B's z = 0.
double FindFirstContact(const StudyPath& path, const Pose& X_WB, double from_mm, double to_mm) {
  for (double depth = from_mm; depth < to_mm; depth += 0.02) {
    for (int i = -90; i <= 90; ++i) {
      const double angle = 0.015 * i;
      const double r = path.saw.radius_mm();
      if (path.solid.distance_mm(X_WB.Point({r * std::sin(angle), 0, r - depth - r * std::cos(angle)})) < 0)
        return depth;
    }
  }
  throw Error("there is no bone on the path of the cut");
}

void SetMotion(StudyPath& path, const Pose& X_WB, double contact_mm, double hand_mm_per_s, double tool_mm_per_s) {
  const double T = path.duration_s;
  const auto down = [&](double speed) {
    return Way(contact_mm - 0.4, {{0, 0}, {0.1, speed}, {T - 0.1, speed}, {T, 0}});
  };
  const UprightMotion hand{Way(), down(hand_mm_per_s), Way(), Way()};
  const UprightMotion tool{Way(), down(tool_mm_per_s), Way(), Way()};
  path.pose = [X_WB, hand, tool, saw = path.saw](Holding holding, double t_s) {
    const Pose X_BT = CalcUprightPose(holding == Holding::kHand ? hand : tool, saw, t_s);
    return Pose{glm::normalize(X_WB.R_AB * X_BT.R_AB), X_WB.Point(X_BT.p_AB)};
  };
}

constexpr double kTruthVoxel_mm = 0.2;  // a fifth of a CT voxel
constexpr double kHuVoxel_mm = 1;       // the size of a CT voxel

CtLaw MakeCtLaw() {
  return WithCalibration(FindCtLaw(DefaultCtLaws(), "mandible_matmap"), "");
}

Bone ImportOrRead(const std::string& data_folder, const std::string& cache_folder) {
  const std::string kept = cache_folder.empty() ? "" : cache_folder + "/visible_human_female.vdb";
  ReadBoneOptions with_hu;
  with_hu.hu = true;
  if (!kept.empty() && std::filesystem::exists(kept)) {
    try {
      Bone bone = ReadBone(kept, with_hu);
      if (bone.voxel_mm() == kTruthVoxel_mm && bone.has_hu()) return bone;
    } catch (const Error&) {
      // The cached bone is unusable, so it is made again below.
    }
  }
  const std::string dicom = data_folder + "/visible_human_female/dicom";
  if (data_folder.empty() || !std::filesystem::is_directory(dicom)) {
    throw Error(fmt::format("the CT of the Visible Human Female is missing{}",
                            data_folder.empty() ? "" : fmt::format(": no folder {}", dicom)));
  }
  ImportOptions options;
  options.voxel_mm = kTruthVoxel_mm;
  options.keep_hu = true;
  options.hu_voxel_mm = kHuVoxel_mm;
  Bone bone = Import(dicom, options).bone;
  if (!kept.empty()) {
    MakeFolder(cache_folder);
    WriteBone(bone, kept);
  }
  return bone;
}

}  // namespace

StudyPath MakeMandiblePath() {
  StudyPath path = MakePlainPath("mandible", "up through the lower border of the generic mandible's body");
  const auto shape = std::make_shared<const MandibleShape>(MandibleParams{});
  const MandibleLandmarks& marks = shape->landmarks();
  const Vec3 up(0, 0, 1);
  Vec3 border = marks.first_molar;
  while (shape->Value(border) < 0) border -= 0.1 * up;
  BonePart part;
  part.X_WB = {StandOn(glm::cross(marks.first_molar_out, up), -up), border};
  part.box_B = {{-11, -2.2, -11}, {11, 2.2, 3}};
  SetMandible(path, shape, part);
  path.duration_s = 2;
  SetMotion(path, part.X_WB, FindFirstContact(path, part.X_WB, -6, 6), 9, 2.4);
  return path;
}

StudyPath MakeCtPath(const std::string& data_folder, const std::string& cache_folder) {
  StudyPath path = MakePlainPath("ct", "down from the crest of the Visible Human Female's mandible (CT)");
  const Bone whole = ImportOrRead(data_folder, cache_folder);
  // The cut is as in scenes/visible_human_osteotomy.toml: behind the last tooth on the left, with the plane of the disc
  // across the arch.
  BonePart part;
  part.X_WB = {StandOn({0.6, 0.8, 0}, {0, 0, 1}), {21.9, -70.05, 47}};
  part.box_B = {{-11, -2.2, -12}, {11, 2.2, 5}};
  SetImported(path, CropBone(whole, part.CalcBounds().Grown(4)), part, MakeCtLaw());
  path.duration_s = 2;
  SetMotion(path, part.X_WB, FindFirstContact(path, part.X_WB, -6, 10), 9, 2.4);
  return path;
}

}  // namespace kerf
