// Exercises and their levels: those that are built in, and those of scene files.
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
  ExerciseKind kind = ExerciseKind::kGroove;
  int difficulty = 0;  // 1: the easiest; 0: not in ListExercises()
  std::string file;    // of the scene
  std::string toml;
};

/// Returns the exercises, ordered from easy to hard.
std::span<const Exercise> ListExercises();
/// Returns the built-in procedures: exercises on the mandible, of several cuts or holes or with other tools, in the
/// order of their files' names. Those that begin with a bone from a file are left out.
std::span<const Exercise> ListProcedures();
/// Returns the exercise or procedure with this id. If there is none, throws kerf::Error that lists the known ones.
const Exercise& FindExercise(std::string_view id);
/// Returns the exercise or procedure whose built-in scene has this file name, or null if there is none.
const Exercise* FindExerciseOf(std::string_view scene_name);
/// Returns the exercise of a scene file. Its id is that of FindExerciseOf() or, if there is none, the scene's name.
/// Throws kerf::Error for a file that is not a scene, or that has no [exercise].
Exercise ReadExercise(const std::string& file);
/// Returns ReadExercise() of a name that ends in .toml, and otherwise FindExercise() of an id. Throws their errors.
Exercise OpenExercise(const std::string& name);

/// Returns the scene of an exercise at a level, 1 to 5. Throws kerf::Error.
Scene MakeExerciseScene(const Exercise& exercise, int level);
Scene MakeExerciseScene(std::string_view id, int level);
/// Returns the same scene with fewer aids: without the depth stop from level 2 on, without the tone from level 3 on,
/// without the blade's colour from level 4 on, and without the gauge at level 5. Aids that the scene lacks are not
/// added. Throws kerf::Error for a scene that is not an exercise, and for an unknown level.
Scene MakeLevel(const Scene& scene, int level);

}  // namespace kerf
