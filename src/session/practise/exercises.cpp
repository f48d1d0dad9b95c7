#include "session/practise/exercises.h"

#include <fmt/format.h>
#include <practise_scenes.h>

#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "base/files/files.h"
#include "cut/force/measured.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Returns a length with one decimal if it has any.
Quantity ShowLength(double mm) {
  const Quantity length{mm, 1, "mm"};
  return FormatQuantity(length) == FormatQuantity({std::round(mm), 1, "mm"}) ? Quantity{mm, 0, "mm"} : length;
}

/// Returns the name of a scene without the number with which its file may begin.
std::string_view SkipNumber(std::string_view scene_name) {
  const std::size_t at = scene_name.find_first_not_of("0123456789");
  return at > 0 && at < scene_name.size() && scene_name[at] == '_' ? scene_name.substr(at + 1) : scene_name;
}

Message DescribeGoal(const Scene& scene, std::string_view id) {
  const SceneExercise& e = scene.exercise;
  const Quantity count{1 + static_cast<double>(e.further.size()), 0, ""};
  const Quantity length = ShowLength(MakeWantedCut(e, DiscSaw{}).length_mm);
  const Quantity depth = ShowLength(e.depth_mm);
  switch (e.kind) {
    case ExerciseKind::kGroove:
      return {MarkMessage("Cut a straight groove {0} deep, no deeper, along the line of {1}."), {depth, length}};
    case ExerciseKind::kStopBeforeFar:
      return {MarkMessage("Cut {0} deep along the line of {1} and stop before the far cortex. Here cortex resists "
                          "{2} times as much as cancellous bone; in a jaw it is thought to be {3} to {4} times."),
              {depth, length, Quantity{CalcCorticalPerCancellous(scene.force, MakeTool(scene)), 1, ""},
               Quantity{kCorticalPerCancellous[0], 1, ""}, Quantity{kCorticalPerCancellous[1], 0, ""}}};
    case ExerciseKind::kBicortical:
      return {MarkMessage("Cut through both cortices along the line of {} with minimum plunge beyond."), {length}};
    case ExerciseKind::kBesideCanal:
      return {MarkMessage("Cut {0} deep along the line of {1} and stay {2} clear of the nerve canal."),
              {depth, length, Quantity{2, 0, "mm"}}};
    case ExerciseKind::kFollowLine:
      return {MarkMessage("Follow the line of {0}, {1} deep, at a constant {2}."),
              {length, depth, Quantity{e.feed_mm_per_s, 0, "mm/s"}}};
    case ExerciseKind::kOsteotomy:
      if (!e.further.empty()) {
        return {MarkMessage("Make the {} planned cuts, each in its plane and to its depth."), {count}};
      }
      if (id == "mandibulotomy") {
        return {MarkMessage("Cut through the bone in the planned plane, between the roots of the incisors. The nerve "
                            "canals end on either side of it."),
                {}};
      }
      if (id != "osteotomy") return {MarkMessage("Cut through the bone in the planned plane."), {}};
      return {MarkMessage("Cut through the bone in the planned plane. The plane crosses a molar and the nerve canal: "
                          "cutting these costs no points."),
              {}};
    case ExerciseKind::kDrillHoles:
      return {MarkMessage("Drill {} holes at their places, through the far side of the bone with minimum plunge."),
              {count}};
  }
  return {};
}

Exercise MakeExercise(const Scene& scene, std::string id, std::string file, std::string toml) {
  Exercise exercise;
  exercise.id = std::move(id);
  exercise.title = scene.TitleOrName();
  exercise.goal_message = DescribeGoal(scene, exercise.id);
  exercise.kind = scene.exercise.kind;
  exercise.goal = FormatMessage(exercise.goal_message);
  exercise.file = std::move(file);
  exercise.toml = std::move(toml);
  return exercise;
}

/// Makes exercises of embedded scenes. `ordered`: their files' names begin with numbers, in the order of difficulty.
std::vector<Exercise> MakeExercises(std::span<const PractiseScene> embedded, bool ordered) {
  std::vector<Exercise> exercises;
  for (const PractiseScene& of : embedded) {
    const Scene scene = ParseScene(of.toml, of.file);
    if (!scene.bone.file.empty()) continue;  // the user has to make the bone first
    exercises.push_back(MakeExercise(scene, std::string(SkipNumber(scene.name)), of.file, of.toml));
    if (ordered) exercises.back().difficulty = static_cast<int>(exercises.size());
  }
  return exercises;
}

}  // namespace

std::span<const Exercise> ListExercises() {
  static const std::vector<Exercise> kExercises = MakeExercises(kPractiseScenes, true);
  return kExercises;
}

std::span<const Exercise> ListProcedures() {
  static const std::vector<Exercise> kProcedures = MakeExercises(kProcedureScenes, false);
  return kProcedures;
}

const Exercise& FindExercise(std::string_view id) {
  std::string names;
  for (const std::span<const Exercise> list : {ListExercises(), ListProcedures()}) {
    for (const Exercise& exercise : list) {
      if (exercise.id == id) return exercise;
      names += (names.empty() ? "" : ", ") + exercise.id;
    }
  }
  throw Error(fmt::format("there is no exercise \"{}\"; the exercises are {}", id.substr(0, 60), names));
}

const Exercise* FindExerciseOf(std::string_view scene_name) {
  for (const std::span<const Exercise> list : {ListExercises(), ListProcedures()}) {
    for (const Exercise& exercise : list) {
      if (exercise.id == SkipNumber(scene_name)) return &exercise;
    }
  }
  return nullptr;
}

Exercise ReadExercise(const std::string& file) {
  std::string toml = ReadTextFile(file);
  const Scene scene = ParseScene(toml, file);
  if (!scene.exercise.given) throw Error(fmt::format("{}: is not an exercise: it has no [exercise]", file));
  const Exercise* known = FindExerciseOf(scene.name);
  return MakeExercise(scene, known != nullptr ? known->id : scene.name, file, std::move(toml));
}

Exercise OpenExercise(const std::string& name) {
  return std::filesystem::path(name).extension() == ".toml" ? ReadExercise(name) : FindExercise(name);
}

Scene MakeExerciseScene(const Exercise& exercise, int level) {
  return MakeLevel(ParseScene(exercise.toml, exercise.file), level);
}

Scene MakeExerciseScene(std::string_view id, int level) {
  return MakeExerciseScene(FindExercise(id), level);
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
