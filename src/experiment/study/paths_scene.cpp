// A scene as a path of a study.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/files/files.h"
#include "bone/material/ct_law_table.h"
#include "bone/material/region_table.h"
#include "bone/vdb/bonefile.h"
#include "experiment/study/case_run.h"
#include "experiment/study/paths.h"
#include "kerf/error.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"

namespace kerf {
StudyPath MakeScenePath(const std::string& name, const std::string& scene_file) {
  const Scene scene = ReadScene(scene_file);
  if (scene.coupling.params.blade_bends) {
    throw Error(fmt::format("{}: [coupling] blade_bends: the reference of a study has a rigid blade", scene_file));
  }
  StudyPath path = MakePlainPath(name, scene.TitleOrName());
  path.saw = MakeDiscSaw(scene);
  path.rpm = scene.tool.CalcTickRpm();
  path.law = scene.force;
  path.coupling = MakeCoupledParams(scene).coupling;

  const auto way = std::make_shared<const Path>(MakePath(scene));
  for (const PathSegment& segment : way->segments()) {
    if (segment.retract_before && segment.start_s > 0) path.lifts_s.push_back(segment.start_s);
  }
  path.duration_s = way->segments().back().end_s;
  path.pose = [way](Holding, double t_s) {
    const std::size_t last = way->segments().size() - 1;
    std::size_t segment = 0;
    const auto is_over = [&](const PathSegment& now, const PathSegment& next) {
      return t_s > now.end_s + (next.retract_before ? kSameTime_s : 0);
    };
    while (segment < last && is_over(way->segments()[segment], way->segments()[segment + 1])) ++segment;
    return way->CalcPose(segment, t_s);
  };

  if (!scene.bone.materials.empty()) {
    path.materials = ParseRegionTable(ReadTextFile(scene.bone.materials), scene.bone.materials);
  }
  switch (scene.bone.source) {
    case BoneSource::kFile: {
      ReadBoneOptions with_hu;
      with_hu.hu = true;
      Bone bone = ReadBone(scene.bone.file, with_hu);
      if (!scene.bone.materials.empty()) bone.set_materials(path.materials);
      std::optional<CtLaw> law;
      if (scene.material.kind == MaterialKind::kCt) {
        const std::vector<CtLaw> laws =
            scene.material.ct_law_file.empty()
                ? DefaultCtLaws()
                : ParseCtLaws(ReadTextFile(scene.material.ct_law_file), scene.material.ct_law_file);
        law = WithCalibration(FindCtLaw(laws, scene.material.ct_law), scene.material.ct_calibration);
        if (scene.material.ct_all) throw Error("a study takes E from the CT only in cancellous bone");
      }
      SetImported(path, std::move(bone), std::nullopt, law);
      break;
    }
    case BoneSource::kBlock:
    case BoneSource::kPlate:
      SetBlock(path, scene.bone.block);
      break;
    case BoneSource::kMandible:
      SetMandible(path, std::make_shared<const MandibleShape>(scene.bone.mandible), std::nullopt);
      break;
  }
  return path;
}

}  // namespace kerf
