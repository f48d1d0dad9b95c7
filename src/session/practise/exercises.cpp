#include "session/practise/exercises.h"

#include <fmt/format.h>
#include <practise_scenes.h>

#include <cmath>
#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

/// Returns a length with one decimal if it has any.
Quantity ShowLength(double mm) {
  const Quantity length{mm, 1, "mm"};
  return FormatQuantity(length) == FormatQuantity({std::round(mm), 1, "mm"}) ? Quantity{mm, 0, "mm"} : length;
}

Message DescribeGoal(const SceneExercise& e) {
  const Quantity length = ShowLength(MakeWantedCut(e, DiscSaw{}).length_mm);
  const Quantity depth = ShowLength(e.depth_mm);
  switch (e.kind) {
    case ExerciseKind::kGroove:
      return {MarkMessage("Cut a straight groove {0} deep, no deeper, along the line of {1}."), {depth, length}};
    case ExerciseKind::kStopBeforeFar:
      return {MarkMessage("Cut {0} deep along the line of {1} and stop before the far cortex."), {depth, length}};
    case ExerciseKind::kBicortical:
      return {MarkMessage("Cut through both cortices along the line of {} with minimum plunge beyond."), {length}};
    case ExerciseKind::kBesideCanal:
      return {MarkMessage("Cut {0} deep along the line of {1} and stay {2} clear of the nerve canal."),
              {depth, length, Quantity{2, 0, "mm"}}};
    case ExerciseKind::kFollowLine:
      return {MarkMessage("Follow the line of {0}, {1} deep, at a constant {2}."),
              {length, depth, Quantity{e.feed_mm_per_s, 0, "mm/s"}}};
    case ExerciseKind::kOsteotomy:
      return {MarkMessage("Cut through the bone in the planned plane. The plane crosses a molar and the nerve canal: "
                          "cutting these costs no points."),
              {}};
    case ExerciseKind::kDrillHoles:
      return {MarkMessage("Drill {} holes at their places, through the far side of the bone with minimum plunge."),
              {Quantity{1 + static_cast<double>(e.further.size()), 0, ""}}};
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
      exercise.goal_message = DescribeGoal(scene.exercise);
      exercise.goal = FormatMessage(exercise.goal_message);
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
