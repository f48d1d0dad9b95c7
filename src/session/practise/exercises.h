// The exercises that come with the program, and their levels.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "session/scene/scene.h"

namespace kerf {

struct Exercise {
  std::string id;      // "groove"
  std::string title;   // the scene's
  std::string goal;    // a sentence
  int difficulty = 1;  // 1: the easiest
  std::string file;    // of scenes/practise
  std::string toml;
};

inline constexpr int kLevels = 5;

/// Easy to hard.
std::span<const Exercise> ListExercises();
/// Throws Error that names those there are.
const Exercise& FindExercise(std::string_view id);
/// The exercise of a scene that comes with the program: by the file's name; null: none.
const Exercise* FindExerciseOf(std::string_view scene_name);

/// The scene of an exercise at a level, 1 to 5. Throws Error.
Scene MakeExerciseScene(std::string_view id, int level);
/// The same scene with fewer aids: from level 2 on without the depth stop, from 3 without the tone, from 4 without the
/// blade's colour, at 5 without the gauge. Of the aids that a scene has not, none is added. Throws Error for a scene
/// that is no exercise, and for a level that there is none of.
Scene MakeLevel(const Scene& scene, int level);

}  // namespace kerf
