#include "session/run/make_bone.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "base/files/files.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/vdb/bonefile.h"
#include "cut/contact/met_material.h"
#include "kerf/error.h"
#include "session/run/bone_cache.h"

namespace kerf {
namespace {

/// Throws kerf::Error if a file is missing that has the name of the bone that a session leaves. ReadBone() gives other
/// advice.
void CheckSessionBoneExists(const std::string& file) {
  const std::filesystem::path path(file);
  std::error_code failed;
  if (path.filename() != "bone.vdb" || std::filesystem::exists(path, failed) || failed) return;
  throw Error(
      fmt::format("{0}: there is no such file; 'kerf replay RECORDING -o {1}' writes it if it is the bone that "
                  "a recorded session left, and 'kerf import INPUT -o {0}' makes one from a CT or a closed "
                  "surface",
                  file, path.parent_path().string()));
}

/// Makes the bone, with the scene's region table if there is one, otherwise with the bone's own.
Bone MakePlainBone(const Scene& scene, const std::function<void(double)>& progress, const ReadSceneBone& read) {
  MaterialTable materials = DefaultMandibleTable();
  if (!scene.bone.materials.empty()) {
    materials = ParseRegionTable(ReadTextFile(scene.bone.materials), scene.bone.materials);
  }
  switch (scene.bone.source) {
    case BoneSource::kFile: {
      ReadBoneOptions options;
      options.hu = scene.material.kind == MaterialKind::kCt;
      if (!read) CheckSessionBoneExists(scene.bone.file);
      Bone bone = read ? read(options) : ReadBone(scene.bone.file, options);
      if (!scene.bone.materials.empty()) {
        for (const auto& [id, volume_mm3] : bone.CalcRegionVolumes()) {
          if (id == 0 || materials.Contains(id)) continue;
          throw Error(scene.bone.materials + ": has no row for region " + std::to_string(id) + " of " +
                      scene.bone.file);
        }
        bone.set_materials(materials);
      }
      return bone;
    }
    case BoneSource::kBlock:
    case BoneSource::kPlate:
      if (read) return read({});
      return MakeBlock(scene.bone.block, materials, progress);
    case BoneSource::kMandible:
      if (read) return read({});
      return MakeCachedMandible(scene.bone.mandible, materials, progress);
  }
  throw Error("the scene does not specify a bone");
}

}  // namespace

Bone MakeSceneBone(const Scene& scene, const std::function<void(double)>& progress, MaterialSummary* material,
                   const ReadSceneBone& read) {
  Bone bone = MakePlainBone(scene, progress, read);
  MaterialSummary summary = ApplySceneMaterial(scene, bone);
  CheckTissues(scene.force, bone);
  if (material != nullptr) *material = std::move(summary);
  return bone;
}

}  // namespace kerf
