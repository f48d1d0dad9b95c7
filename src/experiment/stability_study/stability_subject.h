// The subject that `kerf stability` examines for a scene: its tool where its path first touches the bone, its device
// and its hand.
#pragma once

#include "experiment/stability/margins.h"
#include "session/run/loop_setup.h"
#include "session/scene/scene.h"

namespace kerf {

/// The place where a path first touches the bone.
struct FirstTouch {
  double time_s = 0;  // on the path, accurate to the time in which the tool moves by a voxel
  Pose X_WT;          // the tool shortly before, clear of the bone by less than 1 mm
  Vec3 into_W{0};     // the feed's direction there, unit length
};

/// Throws Error if the path never touches the bone, if the tool is set down inside the bone or so near to it that it is
/// never clear, if the tool only rotates when it touches the bone, or if it is a disc that touches the bone with a
/// flat, where no tooth cuts.
FirstTouch FindFirstTouch(const Scene& scene, const Bone& bone);

/// Returns the scene at the place of `touch`, as `kerf loop` would run it. The bone is cropped to the surroundings:
/// parts that the tool cannot reach in a few seconds are left out. `setup`: the scene's, from MakeLoopSetup().
StabilitySubject MakeStabilitySubject(const Scene& scene, const LoopSetup& setup, const Bone& bone,
                                      const FirstTouch& touch);

}  // namespace kerf
