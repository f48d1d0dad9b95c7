// The measures of a score: key, name, unit and formula of each, and whether it is scored.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/table/table.h"
#include "loop/record/damage.h"
#include "loop/record/seal.h"
#include "session/marks/structures.h"
#include "session/scene/exercise.h"
#include "session/score/cut_picture.h"

namespace kerf {

struct MeasureInfo {
  const char* key;  // includes the unit; used in tables, JSON and CSV
  const char* name;
  const char* unit;      // empty: dimensionless
  const char* formula;   // in words
  const char* evidence;  // publication showing that it distinguishes novices from experts; empty: for information only
  /// Value at which half of the points remain: CalcPoints(). 0 if the measure is not scored, or if the exercise defines
  /// it (MeasureRow::half).
  double half = 0;
  bool scored() const { return evidence[0] != '\0'; }
};

/// Returns all measures, in the order in which tables list them.
std::span<const MeasureInfo> Measures();
/// Throws kerf::Error for an unknown key.
const MeasureInfo& FindMeasure(std::string_view key);

/// A measure that is scored in an exercise, and its weight.
struct Goal {
  const char* key;
  double weight;
};
std::span<const Goal> GoalsOf(ExerciseKind kind);

/// A measure of one recording.
struct MeasureRow {
  const MeasureInfo* info = nullptr;
  std::optional<double> value;   // none: could not be measured
  double half = 0;               // as in MeasureInfo, for this exercise
  double goal = 0;               // value up to which no points are lost
  double weight = 0;             // 0: not scored here
  std::optional<double> points;  // 0 to 1, if it is scored and has a value
};

/// Returns 1 up to the goal, and beyond it 2^(-(|value| - goal) / (half - goal)), which is 0.5 at `half`.
double CalcPoints(double value, double half, double goal = 0);

/// The stretch of the line outside of which the cut is not as deep as wanted.
struct DeepStretch {
  double share = 0;         // fraction of the line
  bool from_start = false;  // it begins at the start of the line
  double shallow_mm = 0;    // mean of what lacks to the wanted depth within the stretch
  bool goes_on = false;     // the tool also cut beyond it, less deeply
};

/// Fraction of the wanted cut from which it counts as whole, while it is made and in the review. What lacks then costs
/// less than any fault that the review names.
inline constexpr double kWholeCut = 0.98;
/// Minimum of the measure line_share; a smaller value means that the exercise was abandoned or interrupted.
inline constexpr double kFinishedShare = 0.8;
/// Total, out of 100, from which a level is passed and the next one is recommended.
inline constexpr double kGoodTotal = 70;
/// Returns true if an attempt does not pass its level, whatever its total: the bone is to be cut through, and is not.
inline bool IsNotThrough(ExerciseKind kind, double cut_share) {
  return kind == ExerciseKind::kOsteotomy && cut_share < kWholeCut;
}

/// Deviation of the feed, as a fraction of the wanted one, up to which no points are lost.
inline constexpr double kFeedGood = 0.25;
/// Force on the hand from which pressing is the reason for a feed that is too slow.
inline constexpr double kPressed_N = 4;

/// The feed along the line: FeedMeter.
struct FeedAlong {
  double slowest_mm_per_s = 0;
  double fastest_mm_per_s = 0;
  double mean_mm_per_s = 0;
  double slow_share = 0;    // fraction of the time in which it was too slow
  double fast_share = 0;    // and too fast
  double rest_share = 0;    // and in which the tool rested
  double slow_force_N = 0;  // mean force on the hand while the tool was too slow, but did not rest
};

/// A tooth, canal or lesion that was injured outside the wanted cut and its margin. Costs no points of its own: what
/// was removed there is part of outside_mm3.
struct OutsideInjury {
  StructureResult structure;  // only what was removed there
  double away_mm = 0;         // distance of its centre from the wanted cut
};

/// How a hole was drilled, where the drill was deepest in it.
struct HoleResult {
  double depth_mm = 0;   // of the drill's tip below the surface, along its own axis
  double beyond_mm = 0;  // of the tip beyond the far side; negative: before it
  double offset_mm = 0;  // distance of the drill's axis from the wanted one, at the surface
  double angle_deg = 0;  // between both axes
  bool through = false;  // the drill has left the far side over its whole width
};

/// Measures and score of a recording.
struct ScoreSheet {
  std::string recording;  // file name
  std::string scene;
  std::string title;
  std::string created;               // time of the recording, UTC
  std::optional<ExerciseKind> kind;  // none: not an exercise
  int level = 0;
  SceneExercise exercise;        // the goal; SceneExercise::given is false if there is none
  std::vector<MeasureRow> rows;  // one for each of Measures()
  /// 0 to 100: 100 x cut_share x the weighted mean of the points of the exercise's goals. None if there was no exercise
  /// or the attempt is incomplete.
  std::optional<double> total;
  /// Reasons why the attempt is not graded, one phrase for each: the recording is cut short or damaged, it continues
  /// another one, the session ended with a failure, or the exercise is not finished. The available measures are set,
  /// but there are no points and no total.
  std::vector<std::string> incomplete;
  RecordingState state = RecordingState::kWhole;
  std::string steps_digest;      // of the inputs of all ticks: CalcStepsDigests()
  std::string beginning_digest;  // of the inputs of the first ticks
  RecordingSeal seal;
  std::vector<std::string> warnings;
  /// Of an exercise in drilling: each hole in the order of the scene; none: it was not begun.
  std::vector<std::optional<HoleResult>> holes;
  // Not in JSON and CSV; none if there was no exercise or nothing was cut:
  std::optional<CutPicture> picture;
  std::optional<double> beside_mm;      // mean distance of the removed bone from the wanted plane
  std::optional<double> farthest_mm;    // its largest distance from that plane
  std::optional<double> plan_nerve_mm;  // distance of the wanted cuts from the nerve canal; at most 0: they cross it
  double below_mm3 = 0;                 // part of outside_mm3 that lies below the wanted cut, in its plane
  double beyond_mm3 = 0;                // part of outside_mm3 that lies beyond an end of the wanted cut, in its plane
  std::optional<double> begun_share;    // fraction of the line where bone was removed, however little
  std::optional<double> depth_mm;       // mean depth of the cut there
  std::optional<double> through_mm;     // thickness of the bone where it was cut through, but should not be
  std::optional<DeepStretch> deep;      // none: nowhere deep enough
  std::optional<FeedAlong> feed_along;  // along the line, at depth; none: too short
  bool turned = false;                  // the spindle turned
  bool strokes = false;                 // the tool was a blade with a stroke, which plunges along the line
  std::vector<OutsideInjury> injured;   // the largest first
  // What a planned cut that crosses structures removed of them within its margin.
  std::vector<StructureResult> crossed;
  bool canal_severed = false;  // a nerve canal was cut over its whole cross-section

  /// Throws kerf::Error for an unknown key.
  std::optional<double> Get(std::string_view key) const;
};

/// Returns all measures without values, with the weights of the exercise, if any.
ScoreSheet MakeSheet(std::optional<ExerciseKind> kind);
void SetValue(ScoreSheet& sheet, std::string_view key, std::optional<double> value);
/// Computes the points of measures with values, and the total. An incomplete sheet gets neither.
void CalcTotal(ScoreSheet& sheet);

/// Describes the chain of a recording's blocks: "whole"; "broken"; "not closed", for example after a kill; "none" for
/// recordings of version 1.
const char* DescribeChain(const RecordingSeal& seal);

/// Returns a readable table.
std::string FormatSheet(const ScoreSheet& sheet);
/// Returns JSON with stable keys that include the units.
nlohmann::ordered_json SheetJson(const ScoreSheet& sheet);
std::string FormatSheetJson(const ScoreSheet& sheet);
/// A line of the CSV: a measure, the total, or whether the attempt is complete.
struct SheetLine {
  std::string key;
  std::string name;
  std::string unit;
  std::string value;
  int scored = 0;
  std::optional<double> weight;
  std::optional<double> points;
};
const Columns<SheetLine>& SheetColumns();
std::string FormatSheetCsv(const ScoreSheet& sheet);
/// Returns a self-contained HTML page: the review, the picture of the cut, and all measures.
std::string FormatSheetHtml(const ScoreSheet& sheet);
/// Returns the table for docs/practise.md: each measure with unit, formula and evidence.
std::string FormatMeasuresMarkdown();

}  // namespace kerf
