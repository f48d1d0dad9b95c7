// Built-in exercises and their levels.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/core/message.h"
#include "session/scene/scene.h"

namespace kerf {

struct Exercise {
  std::string id;     // for example "groove"
  std::string title;  // title of the scene
  std::string goal;   // one sentence, in English
  Message goal_message;
  int difficulty = 1;  // 1: the easiest
  std::string file;    // file in scenes/practise
  std::string toml;
};

/// Returns the exercises, ordered from easy to hard.
std::span<const Exercise> ListExercises();
/// Returns the exercise with this id. If there is none, throws kerf::Error that lists the known exercises.
const Exercise& FindExercise(std::string_view id);
/// Returns the exercise whose built-in scene has this file name, or null if there is none.
const Exercise* FindExerciseOf(std::string_view scene_name);

/// Returns the scene of an exercise at a level, 1 to 5. Throws kerf::Error.
Scene MakeExerciseScene(std::string_view id, int level);
/// Returns the same scene with fewer aids: without the depth stop from level 2 on, without the tone from level 3 on,
/// without the blade's colour from level 4 on, and without the gauge at level 5. Aids that the scene lacks are not
/// added. Throws kerf::Error for a scene that is not an exercise, and for an unknown level.
Scene MakeLevel(const Scene& scene, int level);

}  // namespace kerf
