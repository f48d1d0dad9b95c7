// What somebody begins with: a scene, a bone, or a CT.
#pragma once

#include <functional>
#include <string>

#include "session/scene/scene.h"

namespace kerf {

struct OpenedInput {
  Scene scene;
  std::string scene_file;  // that a recording names; empty when there is none
};

struct OpenOptions {
  std::string folder;     // of the session: a bone that is imported goes there
  double voxel_mm = 0.2;  // of one that is imported
};

/// `input`: empty (the generic mandible), a scene (.toml), a bone (.vdb), a DICOM folder, or whatever `kerf import`
/// takes. Of what is no scene, one is made: the saw of the paper over the left side of the bone. `progress` gets a
/// stage's name and 0..1. Throws Error.
OpenedInput OpenInput(const std::string& input, const OpenOptions& options,
                      const std::function<void(const std::string&, double)>& progress);

/// A scene of that bone's file with the saw over its left side, clear of it: above the thickest place of its front
/// half.
Scene MakeSceneAround(const std::string& bone_file, const Bone& bone);

/// A pose of the tool clear of the bone: the nearest on the way from the bone's middle out through the tool.
Pose FindClearPose(const Bone& bone, const Tool& tool, const Pose& X_WT);

}  // namespace kerf
