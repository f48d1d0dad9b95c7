// The measures: what each is called, its unit, its formula, and whether it counts.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loop/record/damage.h"
#include "loop/record/seal.h"
#include "session/scene/exercise.h"

namespace kerf {

struct MeasureInfo {
  const char* key;  // with its unit; of tables, JSON and CSV
  const char* name;
  const char* unit;      // empty: a number
  const char* formula;   // in words
  const char* evidence;  // published, that it tells novices from experts; empty: for information only
  /// At this value half of the points are left: 2^(-|value| / half). 0 where nothing is scored by it, or where the
  /// exercise says (MeasureRow::half).
  double half = 0;
  bool scored() const { return evidence[0] != '\0'; }
};

/// All of them, in the order of tables.
std::span<const MeasureInfo> Measures();
/// Throws Error when there is none of that key.
const MeasureInfo& FindMeasure(std::string_view key);

/// What counts in an exercise, and how much.
struct Goal {
  const char* key;
  double weight;
};
std::span<const Goal> GoalsOf(ExerciseKind kind);

/// A measure of one recording.
struct MeasureRow {
  const MeasureInfo* info = nullptr;
  std::optional<double> value;   // none: there was nothing to measure it by
  double half = 0;               // as MeasureInfo's, of this exercise
  double weight = 0;             // 0: it does not count here
  std::optional<double> points;  // 0 to 1, where it counts and has a value
};

/// 2^(-|value| / half): 1 at 0, falling strictly.
double CalcPoints(double value, double half);

/// A recording, measured.
struct ScoreSheet {
  std::string recording;  // its file
  std::string scene;
  std::string title;
  std::string created;               // the recording, UTC
  std::optional<ExerciseKind> kind;  // none: it was no exercise
  int level = 0;
  std::vector<MeasureRow> rows;  // one for each of Measures()
  /// 0 to 100: 100 x cut_share x the weighted mean of the points of the exercise's goals. None where there was no
  /// exercise, or the attempt is incomplete.
  std::optional<double> total;
  /// Why it is not graded, a phrase each: the recording is cut short or damaged, it goes on from another one, the
  /// session ended by a failure, the exercise is not finished. Its measures are those of what there is; there are no
  /// points and no total.
  std::vector<std::string> incomplete;
  RecordingState state = RecordingState::kWhole;
  std::string steps_digest;      // of what the ticks were given: CalcStepsDigests()
  std::string beginning_digest;  // of the first of them
  RecordingSeal seal;
  std::vector<std::string> warnings;

  /// Throws Error when there is none of that key.
  std::optional<double> Get(std::string_view key) const;
};

/// All measures without values, with the weights of the exercise if it is one.
ScoreSheet MakeSheet(std::optional<ExerciseKind> kind);
void SetValue(ScoreSheet& sheet, std::string_view key, std::optional<double> value);
/// Gives points to what has values, and the total; none of either to what is incomplete.
void CalcTotal(ScoreSheet& sheet);

/// Of a recording's blocks: "whole"; "broken"; "not closed", as after a kill; "none" in the first version of
/// recordings.
const char* DescribeChain(const RecordingSeal& seal);

/// For people: a table of lines.
std::string FormatSheet(const ScoreSheet& sheet);
/// Stable keys with units.
std::string FormatSheetJson(const ScoreSheet& sheet);
/// key,name,unit,value,scored,weight,points
std::string FormatSheetCsv(const ScoreSheet& sheet);
/// A self-contained page.
std::string FormatSheetHtml(const ScoreSheet& sheet);
/// Of docs/practise.md: each measure with unit, formula and evidence.
std::string FormatMeasuresMarkdown();

}  // namespace kerf
