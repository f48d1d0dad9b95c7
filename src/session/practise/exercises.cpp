#include "session/practise/exercises.h"

#include <fmt/format.h>
#include <practise_scenes.h>

#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

std::string DescribeGoal(const SceneExercise& e) {
  const double length_mm = MakeWantedCut(e, DiscSaw{}).length_mm;
  switch (e.kind) {
    case ExerciseKind::kGroove:
      return fmt::format("Cut a straight groove {:g} mm deep, no deeper, along the line of {:.3g} mm.", e.depth_mm,
                         length_mm);
    case ExerciseKind::kStopBeforeFar:
      return fmt::format("Cut {:g} mm deep along the line of {:.3g} mm and stop before the far cortex.", e.depth_mm,
                         length_mm);
    case ExerciseKind::kBicortical:
      return fmt::format("Cut through both cortices along the line of {:.3g} mm with minimum plunge beyond.",
                         length_mm);
    case ExerciseKind::kBesideCanal:
      return fmt::format("Cut {:g} mm deep along the line of {:.3g} mm and stay 2 mm clear of the nerve canal.",
                         e.depth_mm, length_mm);
    case ExerciseKind::kFollowLine:
      return fmt::format("Follow the line of {:.3g} mm, {:g} mm deep, at a constant {:g} mm/s.", length_mm, e.depth_mm,
                         e.feed_mm_per_s);
    case ExerciseKind::kOsteotomy:
      return "Cut through the bone in the planned plane.";
  }
  return {};
}

}  // namespace

std::span<const Exercise> ListExercises() {
  static const std::vector<Exercise> kExercises = [] {
    std::vector<Exercise> exercises;
    for (const PractiseScene& embedded : kPractiseScenes) {
      const Scene scene = ParseScene(embedded.toml, embedded.file);
      const std::size_t mark = scene.name.find('_');
      Exercise exercise;
      exercise.id = scene.name.substr(mark + 1);
      exercise.title = scene.title;
      exercise.goal = DescribeGoal(scene.exercise);
      exercise.difficulty = static_cast<int>(exercises.size()) + 1;
      exercise.file = embedded.file;
      exercise.toml = embedded.toml;
      exercises.push_back(std::move(exercise));
    }
    return exercises;
  }();
  return kExercises;
}

const Exercise& FindExercise(std::string_view id) {
  std::string names;
  for (const Exercise& exercise : ListExercises()) {
    if (exercise.id == id) return exercise;
    names += (names.empty() ? "" : ", ") + exercise.id;
  }
  throw Error(fmt::format("there is no exercise \"{}\"; the exercises are {}", id.substr(0, 60), names));
}

const Exercise* FindExerciseOf(std::string_view scene_name) {
  for (const Exercise& exercise : ListExercises()) {
    const std::string_view file = exercise.file;
    if (file.substr(0, file.rfind('.')) == scene_name) return &exercise;
  }
  return nullptr;
}

Scene MakeExerciseScene(std::string_view id, int level) {
  const Exercise& exercise = FindExercise(id);
  return MakeLevel(ParseScene(exercise.toml, exercise.file), level);
}

Scene MakeLevel(const Scene& scene, int level) {
  if (!scene.exercise.given) throw Error(fmt::format("{}: is not an exercise: it has no [exercise]", scene.name));
  CheckRange("level", level, FindRange<SceneExercise>("level"));
  Scene made = scene;
  SceneExercise& e = made.exercise;
  e.level = level;
  if (level >= 2) e.depth_stop = false;
  if (level >= 3) e.sound = false;
  if (level >= 4) e.colour = false;
  if (level >= 5) e.gauge = false;
  return made;
}

}  // namespace kerf
