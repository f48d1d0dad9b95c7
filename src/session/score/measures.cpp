#include "session/score/measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr const char* kPlunge =
    "plunge past the far cortex: novices 11.9, experienced 6.1 mm (cadaver, n = 30, p < 0.001, 2017); 7.6 against 5.1 "
    "mm (Alajmo 2012); drills, as a stand-in for saws";
constexpr const char* kAccuracy =
    "planned against achieved cuts: freehand 2.1 mm, pitch 4.5, roll 7.4 degrees; navigated 1.2 mm, 3.5, 2.6 degrees "
    "(Bernstein 2017, 224 cuts each); cut-off 2 mm and 4 degrees";
constexpr const char* kProduct =
    "remaining bone, judged both by a program and by people (Mikkelsen 2024, 33 trainees), and compared with experts "
    "voxel by voxel (Kerwin 2012)";
constexpr const char* kTimePath =
    "time (p <= 0.001) and path length (p <= 0.007) distinguish the groups (ArthroS, n = 60)";
constexpr const char* kStructures =
    "drilling near, exposing and injuring critical structures (Sewell 2008); experts more cautious near them (Ioannou "
    "2017)";
constexpr const char* kJitter = "jitter and smoothness of the motion distinguish residents from experts (microscope)";
constexpr const char* kFeed =
    "the goal of the exercise follow_line itself; no study shows that it distinguishes the groups";
constexpr const char* kHoles =
    "the goal of the exercise drill_holes itself; no study shows that it distinguishes the groups";
constexpr const char* kNone = "";

constexpr std::array kMeasures{
    MeasureInfo{"cut_share", "fraction of the wanted cut that was made", "",
                "fraction of the wanted cut's plane in bone where bone was removed within the margin", kProduct, 0},
    MeasureInfo{
        "line_share", "fraction of the line that was cut to half depth", "",
        "fraction of the line where the tool's rim was at least half as deep as wanted, within 8 mm of the wanted "
        "plane; a disc of radius R at the depth d is that deep up to about sqrt(R d) ahead of its lowest point; below "
        "0.8 the exercise is not finished",
        kNone, 0},
    MeasureInfo{"depth_error_mean_mm", "depth error, mean", "mm",
                "mean over the line of |depth reached - depth wanted|", kNone, 0},
    MeasureInfo{"depth_error_p95_mm", "depth error, 95th percentile", "mm",
                "95th percentile over the line of |depth reached - depth wanted|", kNone, 0},
    MeasureInfo{"depth_error_worst_mm", "depth error, worst", "mm",
                "largest over the line of |depth reached - depth wanted|", kNone, 0},
    MeasureInfo{"too_deep_mm", "too deep by at most", "mm",
                "largest over the line of depth reached - depth wanted, 0 where it is not too deep", kPlunge, 1},
    MeasureInfo{
        "plunge_max_mm", "plunge past the far side, largest", "mm",
        "largest distance of the tool's rim, along the line, beyond the point where the wanted plane leaves the bone",
        kPlunge, 5},
    MeasureInfo{"plunge_mean_mm", "plunge past the far side, mean of the passes", "mm",
                "mean of the largest distance in each pass in which the rim was beyond by 0.1 mm or more", kNone, 0},
    MeasureInfo{"plunges", "passes beyond the far side", "", "number of such passes", kNone, 0},
    MeasureInfo{
        "plane_offset_mm", "offset of the cut's plane", "mm",
        "signed distance of the fitted mid-plane from the wanted one, at the centre of the bone in the wanted cut",
        kAccuracy, 2},
    MeasureInfo{
        "plane_roll_deg", "roll of the cut's plane about the line", "degrees",
        "angle by which the fitted plane leans to the side; of a bur, the mean over the line of the angle by which "
        "its axis leaned where its tip was deepest; none if it was nowhere half as deep as wanted",
        kNone, 0},
    MeasureInfo{"plane_yaw_deg", "yaw of the cut's plane about the depth direction", "degrees",
                "angle by which it is turned away from the line", kNone, 0},
    MeasureInfo{"plane_angle_deg", "angle between wanted and fitted plane", "degrees", "between their normals, 0 to 90",
                kAccuracy, 4},
    MeasureInfo{"hole_offset_mm", "offset of a hole, largest", "mm",
                "largest distance of the drill's axis, where it was deepest in a hole, from the wanted axis, at the "
                "surface",
                kHoles, 1},
    MeasureInfo{"hole_angle_deg", "angle of a hole, largest", "degrees",
                "largest angle between the drill's axis, where it was deepest in a hole, and the wanted axis", kHoles,
                4},
    MeasureInfo{"holes_through", "holes through the bone", "",
                "number of holes in which the drill left the far side over its whole width", kNone, 0},
    MeasureInfo{"outside_mm3", "removed outside the wanted cut and its margin", "mm3",
                "volume removed further than the margin from the wanted cut", kProduct, 0},
    MeasureInfo{"removed_mm3", "removed in total", "mm3", "volume before - volume after", kNone, 0},
    MeasureInfo{"planned_mm3", "bone in the wanted cut", "mm3",
                "its area in bone x the width of the cut; of several cuts, the sum", kNone, 0},
    MeasureInfo{"under_mm3", "bone left in the wanted cut", "mm3",
                "planned_mm3 - cut_share x planned_mm3, of which at most removed_mm3 - outside_mm3 counts", kNone, 0},
    MeasureInfo{"margin_mm3", "removed within the margin around the wanted cut", "mm3",
                "removed_mm3 - outside_mm3 - (planned_mm3 - under_mm3)", kNone, 0},
    MeasureInfo{"dice", "overlap of wanted and removed (Dice)", "",
                "2 (planned_mm3 - under_mm3) / (planned_mm3 + removed_mm3)", kNone, 0},
    MeasureInfo{"kerf_width_mm", "width of the cut", "mm",
                "(removed_mm3 - outside_mm3) / area of the wanted cut that was cut; larger where it went too deep",
                kNone, 0},
    MeasureInfo{"force_mean_N", "force on the hand, mean", "N", "mean over the time in contact of |force|", kNone, 0},
    MeasureInfo{"force_peak_N", "force on the hand, peak", "N", "largest |force|", kNone, 0},
    MeasureInfo{"force_rms_N", "force on the hand, root mean square", "N", "over the time in contact", kNone, 0},
    MeasureInfo{"force_over_s", "time above the force limit", "s", "time with |force| > force_limit_N", kNone, 0},
    MeasureInfo{
        "feed_mean_mm_per_s", "feed, mean", "mm/s",
        "mean of the feed along the line, as for feed_error; without an exercise, in an osteotomy, and if the line was "
        "not followed at depth, mean speed of the tool's centre, smoothed over 0.2 s, in contact",
        kNone, 0},
    MeasureInfo{"feed_cv", "unevenness of the speed", "",
                "standard deviation of the speed of the tool's centre, smoothed over 0.2 s, in contact / its mean",
                kNone, 0},
    MeasureInfo{
        "feed_error", "deviation from the wanted feed", "",
        "mean over time of |feed - wanted feed| / wanted feed, with means of the feed along the line over 0.5 s, "
        "where the tool is at least half as deep as wanted and not in the first or last tenth of the line",
        kFeed, 0.5},
    MeasureInfo{"sparc", "smoothness of the motion (SPARC)", "",
                "- arc length of the speed's amplitude spectrum, 0 to 20 Hz, both relative to their maxima "
                "(Balasubramanian 2012)",
                kNone, 0},
    MeasureInfo{"jitter_mm", "jitter of the tool", "mm",
                "median, in contact, of the distance of the tool's centre from its mean over the surrounding 0.1 s",
                kJitter, 0.1},
    MeasureInfo{"time_total_s", "time", "s",
                "from the first motion of the tool or start of the spindle to the end of the recording", kTimePath, 0},
    MeasureInfo{"time_active_s", "time in contact", "s", "time in which the tool touched bone", kNone, 0},
    MeasureInfo{"path_length_mm", "path length", "mm", "of the tool's centre, 50 points a second", kTimePath, 0},
    MeasureInfo{"strokes", "strokes", "",
                "number of contacts of the tool with the bone, each at least 0.3 s after the previous one", kNone, 0},
    MeasureInfo{"nerve_distance_mm", "smallest distance to the nerve canal", "mm",
                "of the spinning tool from the canal's region; below 0: depth inside it", kNone, 0},
    MeasureInfo{"near_miss_s", "time within 2 mm of the nerve canal", "s", "of the spinning tool", kStructures, 4},
    MeasureInfo{"breaches", "cuts into the nerve canal", "",
                "number of times that a tooth cut in its region, at least 0.3 s apart", kStructures, 1},
    MeasureInfo{"breach_mm3", "removed from the nerve canal", "mm3", "volume of its region before - after", kStructures,
                1},
};

constexpr std::array kGroove{Goal{"too_deep_mm", 3},   Goal{"plane_offset_mm", 1}, Goal{"plane_angle_deg", 1},
                             Goal{"outside_mm3", 1},   Goal{"jitter_mm", 1},       Goal{"path_length_mm", 0.5},
                             Goal{"time_total_s", 0.5}};
constexpr std::array kThrough{Goal{"plunge_max_mm", 3}, Goal{"plane_offset_mm", 1},  Goal{"plane_angle_deg", 1},
                              Goal{"jitter_mm", 1},     Goal{"path_length_mm", 0.5}, Goal{"time_total_s", 0.5}};
constexpr std::array kCanal{Goal{"near_miss_s", 2}, Goal{"breaches", 1},         Goal{"breach_mm3", 2},
                            Goal{"too_deep_mm", 2}, Goal{"plane_offset_mm", 1},  Goal{"plane_angle_deg", 1},
                            Goal{"jitter_mm", 1},   Goal{"path_length_mm", 0.5}, Goal{"time_total_s", 0.5}};
constexpr std::array kLine{Goal{"feed_error", 5},       Goal{"plane_offset_mm", 2}, Goal{"plane_angle_deg", 2},
                           Goal{"outside_mm3", 2},      Goal{"jitter_mm", 2},       Goal{"too_deep_mm", 1},
                           Goal{"path_length_mm", 0.5}, Goal{"time_total_s", 0.5}};
constexpr std::array kOsteotomy{Goal{"plane_offset_mm", 3}, Goal{"plane_angle_deg", 3},  Goal{"outside_mm3", 1},
                                Goal{"jitter_mm", 0.5},     Goal{"path_length_mm", 0.5}, Goal{"time_total_s", 0.5}};

constexpr std::array kHoleGoals{Goal{"plunge_max_mm", 3}, Goal{"hole_offset_mm", 2},   Goal{"hole_angle_deg", 2},
                                Goal{"outside_mm3", 1},   Goal{"path_length_mm", 0.5}, Goal{"time_total_s", 0.5}};

MeasureRow& FindRow(ScoreSheet& sheet, std::string_view key) {
  const MeasureInfo& info = FindMeasure(key);
  return *std::find_if(sheet.rows.begin(), sheet.rows.end(), [&](const MeasureRow& r) { return r.info == &info; });
}

}  // namespace

std::span<const MeasureInfo> Measures() {
  return kMeasures;
}

const MeasureInfo& FindMeasure(std::string_view key) {
  for (const MeasureInfo& info : kMeasures) {
    if (info.key == key) return info;
  }
  throw Error(fmt::format("there is no measure \"{}\"", key));
}

std::span<const Goal> GoalsOf(ExerciseKind kind) {
  switch (kind) {
    case ExerciseKind::kGroove:
    case ExerciseKind::kStopBeforeFar:
      return kGroove;
    case ExerciseKind::kBicortical:
      return kThrough;
    case ExerciseKind::kBesideCanal:
      return kCanal;
    case ExerciseKind::kFollowLine:
      return kLine;
    case ExerciseKind::kOsteotomy:
      return kOsteotomy;
    case ExerciseKind::kDrillHoles:
      return kHoleGoals;
  }
  return {};
}

double CalcPoints(double value, double half, double goal) {
  return std::exp2(-std::max(std::abs(value) - goal, 0.0) / (half - goal));
}

std::optional<double> ScoreSheet::Get(std::string_view key) const {
  const MeasureInfo& info = FindMeasure(key);
  for (const MeasureRow& row : rows) {
    if (row.info == &info) return row.value;
  }
  return {};
}

ScoreSheet MakeSheet(std::optional<ExerciseKind> kind) {
  ScoreSheet sheet;
  sheet.kind = kind;
  for (const MeasureInfo& info : kMeasures) {
    MeasureRow row;
    row.info = &info;
    row.half = info.half;
    sheet.rows.push_back(row);
  }
  if (!kind) return sheet;
  for (const Goal& goal : GoalsOf(*kind)) FindRow(sheet, goal.key).weight = goal.weight;
  return sheet;
}

void SetValue(ScoreSheet& sheet, std::string_view key, std::optional<double> value) {
  if (value && !std::isfinite(*value)) value.reset();
  FindRow(sheet, key).value = value;
}

void CalcTotal(ScoreSheet& sheet) {
  double sum = 0;
  double weights = 0;
  for (MeasureRow& row : sheet.rows) {
    row.points.reset();
    if (row.weight == 0) continue;
    weights += row.weight;
    // A measure without a value, such as the plane if there is no cut, gets no points.
    row.points = row.value ? CalcPoints(*row.value, row.half, row.goal) : 0;
    sum += row.weight * *row.points;
  }
  sheet.total.reset();
  if (!sheet.incomplete.empty()) {
    for (MeasureRow& row : sheet.rows) row.points.reset();
    return;
  }
  if (weights > 0) sheet.total = 100 * sheet.Get("cut_share").value_or(0) * sum / weights;
}

}  // namespace kerf
