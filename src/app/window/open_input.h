// Input of a rehearsal: a scene, a bone, or a CT.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bone/import/volume.h"
#include "session/project/project.h"
#include "session/scene/scene.h"

namespace kerf {

struct OpenedInput {
  Scene scene;
  std::string scene_file;            // named in recordings; empty if there is none
  std::shared_ptr<const Bone> bone;  // of the scene; null if it is to be made of the scene's description
  bool bone_is_saved = true;         // false for an imported bone, which the caller writes to scene.bone.file
  bool bone_was_shown = false;       // OpenWatcher::bone has received `bone` as it is
  std::optional<Project> project;    // if the input is one
  std::map<std::string, std::string> scene_files{};  // of a project: contents of the scene's files, by path
  std::vector<std::string> warnings;                 // of the import, one sentence each
  std::shared_ptr<const Bone> original;              // of a project: the bone before its cuts; otherwise null
  std::shared_ptr<const Volume> ct;                  // of an imported bone: its CT; otherwise null
};

struct OpenOptions {
  std::string bone_file;       // file for an imported bone
  double voxel_mm = 0.2;       // of an imported bone
  std::string mesh_units{};    // of a surface's coordinates; empty: mm, if the size is that of a bone
  std::string project_folder;  // receives the files of a project
  bool make_bone = false;      // makes the bone of a scene that describes one, too
  std::vector<Vec3> keep_W{};  // of a CT: points in the wanted bone and, if it touches other bone, in that
  std::vector<Vec3> drop_W{};
  std::optional<double> iso{};  // of a CT: voxels above this are bone, in the file's own values; nullopt: the default
  // Of DICOM: as in ImportOptions.
  std::string series{};
  bool as_ct = false;
  std::string frame{};
  double spacing_z_mm = 0;
  bool check_placing = false;
};

/// What observes the opening. All functions are called in the opening thread; all but `progress` are optional.
struct OpenWatcher {
  /// Receives a stage's name and a fraction from 0 to 1. May throw Cancelled, which OpenInput() lets pass.
  std::function<void(const std::string&, double)> progress;
  /// Receives a bone to look at: a coarse one (`final` is false), then that of the session.
  std::function<void(std::shared_ptr<const Bone>, bool final)> bone;
  /// Receives a CT once it is read.
  std::function<void(std::shared_ptr<const Volume>)> ct;
};

/// Returns the scene of the built-in bone, with which a rehearsal without an input begins.
Scene MakeDefaultScene();
/// Returns the same scene with so few voxels that its bone is ready within a second. The bone must be a mandible.
Scene MakeCoarse(Scene scene);

/// Returns the name of a case that is imported from a file or folder: that of the file or folder or, if many folders
/// are called so, such as "dicom", that of the folder above it, which usually names the patient.
std::string NameCaseOf(const std::string& input);

/// Returns the extensions of files that can be opened, with the dot, in lower case; the last one is empty, since DICOM
/// files and ZIP files may have none.
std::vector<std::string> ListInputExtensions();

/// Throws Error if an input certainly cannot be opened: it does not exist, its type is unknown, or it is a scene with a
/// fault. Takes a few milliseconds.
void CheckInput(const std::string& input);

/// Opens an input. `input`: empty (the generic mandible), a scene (.toml), a project
/// (.kerf-project), a bone (.vdb), a folder or file of DICOM, a segmentation (.seg.nrrd; the bone is made without a
/// CT), or any other input of `kerf import`. If it is not a scene, a scene is made with the paper's saw over the left
/// side of the bone. Writes no file. Throws Error (one that Import() names if the user can help), or Cancelled if
/// `watcher.progress` does.
OpenedInput OpenInput(const std::string& input, const OpenOptions& options, const OpenWatcher& watcher);

/// Makes a scene with the bone file and the saw above the bone's left side without touching it: above the thickest part
/// of the front half.
Scene MakeSceneAround(const std::string& bone_file, const Bone& bone);

/// Moves the tool outwards along the line from the bone's centre through the tool, to the nearest pose that is clear of
/// the bone, and returns that pose.
Pose FindClearPose(const Bone& bone, const Tool& tool, const Pose& X_WT);

}  // namespace kerf
