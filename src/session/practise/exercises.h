// Built-in exercises and their levels.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "session/scene/scene.h"

namespace kerf {

struct Exercise {
  std::string id;      // "groove"
  std::string title;   // title of the scene
  std::string goal;    // one sentence
  int difficulty = 1;  // 1: the easiest
  std::string file;    // file in scenes/practise
  std::string toml;
};

inline constexpr int kLevels = 5;

/// Ordered from easy to hard.
std::span<const Exercise> ListExercises();
/// Throws kerf::Error that lists the known exercises.
const Exercise& FindExercise(std::string_view id);
/// Returns the exercise of a built-in scene by the name of its file; null: none.
const Exercise* FindExerciseOf(std::string_view scene_name);

/// Returns the scene of an exercise at a level, 1 to 5. Throws kerf::Error.
Scene MakeExerciseScene(std::string_view id, int level);
/// Returns the same scene with fewer aids: from level 2 without the depth stop, from 3 without the tone, from 4 without
/// the blade's colour, at 5 without the gauge. Aids that the scene lacks are not added. Throws kerf::Error for a scene
/// that is not an exercise, and for an unknown level.
Scene MakeLevel(const Scene& scene, int level);

}  // namespace kerf
