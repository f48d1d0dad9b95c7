#include "app/window/open_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "base/files/extension.h"
#include "base/files/files.h"
#include "bone/grid/ct_modulus.h"
#include "bone/import/dicom_input.h"
#include "bone/import/image_fields.h"
#include "bone/import/import.h"
#include "bone/segmentation/mask_file.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "session/run/session_recorder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr std::array kTypes{".vdb",    ".nrrd",   ".nhdr", ".mha", ".mhd", ".vti", ".nii",   ".nii.gz", ".hdr", ".img",
                            ".hdr.gz", ".img.gz", ".stl",  ".obj", ".ply", ".dcm", ".dicom", ".ima",    ".zip"};

/// Default scene of a window; also the basis of scenes for other bones.
constexpr char kDefaultScene[] = R"(title = "Generic mandible"
[bone]
model = "mandible"
[bone.mandible]
voxel_mm = 0.2
[tool]
diameter_mm = 22
thickness_mm = 0.25
teeth = 24
rpm = 7500
[force]
law = "two_component"
[effects.kerf_friction]
coefficient = 0.2
[effects.handpiece]
[device]
profile = "omega_6"
[hand]
model = "H4"
[[path.stroke]]
start_mm = [25.2, 32.3, 16]
end_mm = [25.2, 32.3, 15]
feed_mm_per_s = 3
disc_normal = [0.438, 0.899, 0]
)";

/// Returns whether the file is a segmentation, of which a bone is made without a CT.
bool IsSegmentation(const std::string& path) {
  return Lower(path).ends_with(".seg.nrrd");
}

}  // namespace

std::string NameCaseOf(const std::string& input) {
  constexpr std::array kCommon{"dicom", "dcm", "ct", "image", "images", "img", "series", "study", "data", "export"};
  fs::path path = fs::absolute(input).lexically_normal();
  std::error_code failed;
  if (LowerExtension(input) == ".zip")
    path.replace_extension();
  else if (fs::is_regular_file(path, failed) && DicomInput::Is(input))
    path = path.parent_path();
  if (!path.has_filename()) path = path.parent_path();
  std::string name = path.filename().string();
  const bool common = std::find(kCommon.begin(), kCommon.end(), Lower(name)) != kCommon.end();
  return common && path.parent_path().has_filename() ? path.parent_path().filename().string() : name;
}

Scene MakeSceneAround(const std::string& bone_file, const Bone& bone) {
  Scene scene = MakeDefaultScene();
  scene.title = fs::path(bone_file).stem().string();
  scene.bone.source = BoneSource::kFile;
  scene.bone.file = fs::absolute(bone_file).string();
  const Box3 bounds_W = bone.CalcBounds();
  const Vec3 size = bounds_W.size();
  const Vec3 centre = bounds_W.centre();
  Vec3 above{centre.x + 0.22 * size.x, centre.y - 0.1 * size.y, bounds_W.upper.z};
  const double step_mm = std::max(bone.voxel_mm(), size.z / 200);
  double thickest_mm = 0;
  for (double y = bounds_W.lower.y; y < centre.y; y += size.y / 60) {
    double thick_mm = 0;
    std::optional<double> top_mm;
    for (double z = bounds_W.upper.z; z > bounds_W.lower.z; z -= step_mm) {
      if (bone.SignedDistance({above.x, y, z}) >= 0) continue;
      thick_mm += step_mm;
      if (!top_mm) top_mm = z;
    }
    if (thick_mm <= thickest_mm) continue;
    thickest_mm = thick_mm;
    above = {above.x, y, *top_mm};
  }
  SceneStroke& stroke = scene.path.strokes.front();
  const double reach_mm = CalcRadius(scene.tool.shape);
  stroke.start_mm = above + Vec3{0, 0, reach_mm + 3};
  // A higher structure, such as a ramus, may be next to this point.
  const Vec3 spindle = glm::normalize(stroke.disc_normal);
  const Pose X{glm::angleAxis(std::acos(spindle.z), glm::normalize(glm::cross(Vec3{0, 0, 1}, spindle))),
               stroke.start_mm};
  stroke.start_mm = FindClearPose(bone, MakeTool(scene), X).p_AB;
  stroke.end_mm = stroke.start_mm - Vec3{0, 0, 1};
  return scene;
}

std::vector<std::string> ListInputExtensions() {
  std::vector<std::string> extensions(kTypes.begin(), kTypes.end());
  extensions.insert(extensions.end(), {".toml", kProjectExtension, ""});
  return extensions;
}

void CheckInput(const std::string& input) {
  if (!fs::exists(input)) throw Error(fmt::format("{}: there is no such file or folder", input));
  if (fs::is_directory(input) || IsProjectPath(input)) return;
  const std::string name = Lower(fs::path(input).filename().string());
  if (LowerExtension(input) == ".toml") {
    ReadScene(input);
    return;
  }
  // A DICOM file may have any name.
  if (std::none_of(kTypes.begin(), kTypes.end(), [&](const char* type) { return name.ends_with(type); }) &&
      !DicomInput::Is(input)) {
    throw Error(fmt::format("{}: unknown file type; kerf opens .toml, {}, .kerf-project, and folders of DICOM files",
                            input, fmt::join(kTypes, ", ")));
  }
}

Scene MakeDefaultScene() {
  Scene scene = ParseScene(kDefaultScene, "rehearsal.toml");
  scene.name = "rehearsal";
  return scene;
}

Scene MakeCoarse(Scene scene) {
  constexpr double kCoarseVoxel_mm = 0.8;
  scene.bone.mandible.voxel_mm = std::max(scene.bone.mandible.voxel_mm, kCoarseVoxel_mm);
  return scene;
}

OpenedInput OpenInput(const std::string& input, const OpenOptions& options, const OpenWatcher& watcher) {
  const auto show = [&watcher](const std::shared_ptr<const Bone>& bone, bool final) {
    if (watcher.bone) watcher.bone(bone, final);
  };
  const auto make_bone = [&](OpenedInput& opened) {
    if (opened.bone || !options.make_bone) return;
    opened.bone = std::make_shared<const Bone>(
        MakeSceneBone(opened.scene, [&](double fraction) { watcher.progress("making the bone", fraction); }));
  };
  OpenedInput opened;
  if (input.empty()) {
    opened.scene = MakeDefaultScene();
    return opened;
  }
  const std::string extension = LowerExtension(input);
  if (extension == ".toml") {
    opened.scene = ReadScene(input);
    opened.scene_file = input;
    if (opened.scene.simulation.mode == SceneMode::kSlab) {
      throw Error(
          fmt::format("{}: [simulation] mode = \"slab\" can't be used in the window; set mode = \"voxel\"", input));
    }
    if (opened.scene.bone.source != BoneSource::kFile) {
      make_bone(opened);
      return opened;
    }
    watcher.progress("reading the bone", 0);
    opened.bone = std::make_shared<const Bone>(ReadBone(opened.scene.bone.file, {.hu = true}));
    show(opened.bone, false);  // the scene may change its materials
    watcher.progress("reading the bone", 1);
    return opened;
  }
  if (IsProjectPath(input)) {
    watcher.progress("opening the project", 0);
    opened.project = ReadProject(input, options.project_folder);
    const Project& project = *opened.project;
    opened.scene = project.scene;
    opened.scene_files = ReadSceneFiles(opened.scene, "");
    if (!project.bone_file.empty())
      opened.original = std::make_shared<const Bone>(ReadBone(project.bone_file, {.hu = true}));
    watcher.progress("opening the project", 0.5);
    if (!project.cut_bone_file.empty()) {
      Bone cut = ReadBone(project.cut_bone_file, {.hu = true});
      if (!cut.has_hu() && opened.original && opened.original->has_hu()) CopyHu(cut, *opened.original);
      opened.bone = std::make_shared<const Bone>(std::move(cut));
    } else {
      opened.bone = opened.original;
    }
    if (opened.bone) show(opened.bone, false);  // the scene may change its materials
    watcher.progress("opening the project", 1);
    make_bone(opened);
    return opened;
  }
  if (extension == ".vdb") {
    watcher.progress("reading the bone", 0);
    opened.bone = std::make_shared<const Bone>(ReadBone(input, {.hu = true}));
    show(opened.bone, true);
    opened.bone_was_shown = true;
    watcher.progress("placing the saw", 0);
    opened.scene = MakeSceneAround(input, *opened.bone);
    return opened;
  }
  ImportOptions settings;
  settings.voxel_mm = options.voxel_mm;
  settings.mesh_units = options.mesh_units;
  settings.keep_hu = !IsSurfacePath(input);
  settings.isolate.keep_W = options.keep_W;
  settings.isolate.drop_W = options.drop_W;
  settings.isolate.iso_hu = options.iso.value_or(settings.isolate.iso_hu);
  settings.series = options.series;
  settings.as_ct = options.as_ct;
  settings.frame = options.frame;
  settings.spacing_z_mm = options.spacing_z_mm;
  settings.check_placing = options.check_placing;
  const char* stage = settings.keep_hu ? "importing the CT" : "importing the surface";
  const bool is_mask = IsSegmentation(input);
  if (is_mask) {
    stage = "importing the segmentation";
    settings.keep_hu = false;
    settings.isolate.mask = ReadMaskFile(input, "", {}, false).mask;
  }
  settings.progress = [&](double fraction) { watcher.progress(stage, fraction); };
  settings.take_ct = [&](std::shared_ptr<const Volume> ct) {
    opened.ct = ct;
    if (watcher.ct) watcher.ct(std::move(ct));
  };
  settings.take_preview = [&show](Bone bone) { show(std::make_shared<const Bone>(std::move(bone)), false); };
  ImportResult imported = Import(is_mask ? "" : input, settings);
  for (const std::string& warning : imported.report.warnings) fmt::print(stderr, "kerf: warning: {}\n", warning);
  opened.warnings = imported.report.warnings;
  opened.bone = std::make_shared<const Bone>(std::move(imported.bone));
  opened.bone_is_saved = false;
  show(opened.bone, true);
  opened.bone_was_shown = true;
  watcher.progress("placing the saw", 0);
  opened.scene = MakeSceneAround(options.bone_file, *opened.bone);
  opened.scene.title = NameCaseOf(input);
  return opened;
}

Pose FindClearPose(const Bone& bone, const Tool& tool, const Pose& X_WT) {
  const double reach_mm = CalcReach(tool);
  const double step_mm = std::max(bone.voxel_mm(), reach_mm / 20);
  const auto is_clear = [&](const Pose& X) {
    for (double x = -reach_mm; x <= reach_mm; x += step_mm) {
      for (double y = -reach_mm; y <= reach_mm; y += step_mm) {
        if (x * x + y * y <= reach_mm * reach_mm && bone.SignedDistance(X.Point({x, y, 0})) < bone.voxel_mm()) {
          return false;
        }
      }
    }
    return true;
  };
  const Box3 bounds = bone.CalcBounds();
  Vec3 out = X_WT.p_AB - bounds.centre();
  out = glm::length(out) > 1e-6 ? glm::normalize(out) : Vec3{0, 0, 1};
  const double furthest_mm = glm::length(bounds.size()) + 2 * reach_mm;
  Pose X = X_WT;
  for (double distance_mm = 0; distance_mm <= furthest_mm; distance_mm += 1) {
    X.p_AB = X_WT.p_AB + distance_mm * out;
    if (is_clear(X)) break;
  }
  return X;
}

}  // namespace kerf
