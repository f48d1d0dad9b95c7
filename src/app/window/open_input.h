// Input of a rehearsal: a scene, a bone, or a CT.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "session/project/project.h"
#include "session/scene/scene.h"

namespace kerf {

struct OpenedInput {
  Scene scene;
  std::string scene_file;          // named in recordings; empty if there is none
  std::optional<Project> project;  // if the input is one
};

struct OpenOptions {
  std::string folder;     // folder of the session; an imported bone is written there
  double voxel_mm = 0.2;  // of an imported bone
};

/// Opens an input. `input`: empty (the generic mandible), a scene (.toml), a project (.kerf-project), a bone (.vdb), a
/// DICOM folder, or any other input of `kerf import`. If it is not a scene, a scene is made with the paper's saw over
/// the left side of the bone. `progress` receives a stage's name and a fraction from 0 to 1. Throws Error.
OpenedInput OpenInput(const std::string& input, const OpenOptions& options,
                      const std::function<void(const std::string&, double)>& progress);

/// Makes a scene with the bone file and the saw above the bone's left side without touching it: above the thickest part
/// of the front half.
Scene MakeSceneAround(const std::string& bone_file, const Bone& bone);

/// Moves the tool outwards along the line from the bone's centre through the tool, to the nearest pose that is clear of
/// the bone, and returns that pose.
Pose FindClearPose(const Bone& bone, const Tool& tool, const Pose& X_WT);

}  // namespace kerf
