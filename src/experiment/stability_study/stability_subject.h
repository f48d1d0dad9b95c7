// What a scene asks `kerf stability` to examine: its tool where its path first meets the bone, its device and its hand.
#pragma once

#include "experiment/stability/margins.h"
#include "session/run/loop_setup.h"
#include "session/scene/scene.h"

namespace kerf {

/// Where a path first meets the bone.
struct FirstTouch {
  double time_s = 0;  // on the path, to within a voxel's travel
  Pose X_WT;          // the tool shortly before, clear of the bone by less than 1 mm
  Vec3 into_W{0};     // the feed's direction there, unit length
};

/// Throws Error when the path never meets the bone, the tool is set down inside it or so near that it is never clear,
/// only turns as it touches, or is a disc that meets the bone with its flat, where no tooth bites.
FirstTouch FindFirstTouch(const Scene& scene, const Bone& bone);

/// The scene as `kerf loop` would run it, at that place. The bone is that around the place: what the tool can't get to
/// in a few seconds is left out. `setup`: the scene's, MakeLoopSetup().
StabilitySubject MakeStabilitySubject(const Scene& scene, const LoopSetup& setup, const Bone& bone,
                                      const FirstTouch& touch);

}  // namespace kerf
