#include "session/scene/exercise_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <variant>
#include <vector>

#include "kerf/error.h"
#include "session/scene/scene.h"

namespace kerf {
namespace {

/// Rejects a key that a hole has no use for.
void RefuseEndOfHole(TableReader& reader) {
  if (reader.Has("end_mm")) reader.Fault("end_mm", "end_mm is not used: a hole has no end on the surface; remove it");
}

/// Makes the wanted cuts, to find those that are impossible or that are there twice.
void CheckWantedCuts(const SceneExercise& exercise, const SceneTool& tool, const std::vector<const TomlNode*>& further,
                     TableReader& reader, Faults& faults) {
  Scene scene;
  scene.tool = tool;
  std::vector<WantedCut> cuts;
  try {
    cuts = MakeWantedCuts(exercise, MakeTool(scene));
  } catch (const Error& e) {
    reader.Fault("start_mm", e.what());
    return;
  }
  const char* const what = exercise.kind == ExerciseKind::kDrillHoles ? "hole" : "cut";
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const auto first = std::ranges::find_if(cuts, [&](const WantedCut& cut) { return IsSamePlace(cut, cuts[i]); });
    const auto index = static_cast<std::size_t>(first - cuts.begin());
    if (index == i) continue;
    TableReader(*further[i - 1], "[[exercise.cut]]", faults)
        .Fault("start_mm", fmt::format("{0} {1} has the place and the direction of {0} {2}; move it or remove it", what,
                                       i + 1, index + 1));
  }
}

}  // namespace

void ReadExercise(TableReader& root, SceneExercise& exercise, const SceneTool& tool, const std::string& scene_file,
                  Faults& faults) {
  const TomlNode* table = root.Table("exercise");
  if (table == nullptr) return;
  exercise.given = true;
  TableReader reader(*table, "[exercise]", faults);
  Describe(exercise, reader);
  exercise.place = table->PlaceOf("start_mm", scene_file);
  const bool holes = exercise.kind == ExerciseKind::kDrillHoles;
  if (holes) RefuseEndOfHole(reader);
  const std::vector<const TomlNode*> items = reader.Tables("cut", kMaxExerciseCuts - 1);
  for (const TomlNode* item : items) {
    TableReader cut_reader(*item, "[[exercise.cut]]", faults);
    SceneCut cut;
    cut.depth_mm = exercise.depth_mm;
    Describe(cut, cut_reader);
    cut_reader.Require("start_mm");
    if (holes) {
      RefuseEndOfHole(cut_reader);
    } else {
      cut_reader.Require("end_mm");
    }
    cut.place = item->PlaceOf("start_mm", scene_file);
    cut_reader.Require("into");
    cut_reader.Finish();
    exercise.further.push_back(cut);
  }
  if (!exercise.further.empty() && !holes && exercise.kind != ExerciseKind::kOsteotomy) {
    reader.Fault("cut", "several cuts are only for the kinds \"osteotomy\" and \"drill_holes\"");
  }
  if (!exercise.further.empty() && exercise.depth_stop) {
    reader.Fault("depth_stop", "a depth stop is only for exercises with one cut or hole");
  }
  if (holes && GetForm(tool.shape) != ToolForm::kRound) {
    reader.Fault("kind", fmt::format("the kind \"drill_holes\" requires a drill or a bur, but [tool] shape is \"{}\"",
                                     GetShape(tool.shape)));
  }
  if (!holes && std::holds_alternative<TwistDrill>(tool.shape)) {
    reader.Fault("kind",
                 fmt::format("the kind \"{}\" requires a tool that cuts along a line, but a drill cuts only with "
                             "its tip; use kind = \"drill_holes\" or another tool",
                             kExerciseKindWords[static_cast<std::size_t>(exercise.kind)]));
  }
  if (exercise.kind == ExerciseKind::kFollowLine && GetDrive(tool.shape) != DriveMotion::kRotation) {
    reader.Fault("kind", fmt::format("the kind \"follow_line\" requires a tool that turns, but [tool] shape is \"{}\"",
                                     GetShape(tool.shape)));
  }
  CheckWantedCuts(exercise, tool, items, reader, faults);
  reader.Finish();
}

}  // namespace kerf
