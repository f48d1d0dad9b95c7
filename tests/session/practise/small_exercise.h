// The exercises, on bones so small that an agent finishes in a second.
#pragma once

#include <atomic>
#include <string>
#include <string_view>

#include "session/practise/agents.h"
#include "session/practise/exercises.h"
#include "session/score/score.h"
#include "support/result_folder.h"

namespace kerf::test {

/// Returns the exercise on a block with voxels of 0.25 mm and a line of 5 mm; the canal is a layer of the block.
inline Scene MakeSmallExercise(std::string_view id) {
  Scene scene = MakeExerciseScene(id, 1);
  scene.effects.clear();
  scene.bone.source = BoneSource::kBlock;
  scene.bone.block = BlockParams{};
  scene.bone.block.voxel_mm = 0.25;
  scene.bone.block.size_mm = {20, 9, 9};
  scene.bone.block.layers = {{2, 24}, {7, 32}};
  SceneExercise& e = scene.exercise;
  e.start_mm = {-2.5, 0, 0};
  e.end_mm = {2.5, 0, 0};
  e.into = {0, 0, -1};
  e.depth_mm = 2;
  e.feed_mm_per_s = 4;
  scene.loop.rate_hz = 250;  // a quarter of the usual ticks
  scene.tool.shape = DiscSaw{.diameter_mm = 14, .thickness_mm = 0.5};
  switch (e.kind) {
    case ExerciseKind::kStopBeforeFar:
      e.depth_mm = 4;
      break;
    case ExerciseKind::kBicortical:
      scene.bone.block.size_mm.z = 5;
      scene.bone.block.layers = {{2, 24}, {1.5, 32}, {1.5, 24}};
      e.depth_mm = 5.3;
      break;
    case ExerciseKind::kBesideCanal:
      scene.bone.block.layers = {{2, 24}, {3, 32}, {2, 34}, {2, 32}};
      e.depth_mm = 2.7;
      break;
    case ExerciseKind::kOsteotomy:
      scene.bone.block.size_mm = {8, 9, 5};
      scene.bone.block.layers = {{5, 24}};
      e.start_mm = {-1, 0, 0};
      e.end_mm = {1, 0, 0};
      e.depth_mm = 8;
      break;
    case ExerciseKind::kGroove:
    case ExerciseKind::kFollowLine:
    case ExerciseKind::kDrillHoles:
      break;
  }
  SceneStroke stroke;
  stroke.start_mm = e.start_mm + Vec3(0, 0, CalcRadius(scene.tool.shape) + 1);
  stroke.end_mm = e.start_mm + Vec3(0, 0, CalcRadius(scene.tool.shape));
  stroke.disc_normal = {0, 1, 0};
  scene.path.strokes = {stroke};
  return scene;
}

/// Runs the agent, records the run, and scores the recording.
inline ScoreSheet ScoreAgent(const Scene& scene, const AgentParams& params, const std::string& file) {
  std::atomic<bool> done{false};
  LoopOptions loop;
  loop.virtual_time = true;
  loop.seconds = CalcAgentTime(params, scene);
  loop.output.log = LoopLog::kNone;
  loop.output.record = file;
  loop.output.scene_file = file + ".toml";
  loop.stop = &done;
  loop.driver.make_hand = MakeAgent(params, scene, &done);
  RunLoop(scene, loop, {});
  RecordingReader recording(file);
  return ScoreRecording(recording, {}, {});
}

}  // namespace kerf::test
