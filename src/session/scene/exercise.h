// Section of a scene that makes it an exercise: the wanted cut, and aids for the student.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cut/tool/convex_outline.h"
#include "cut/tool/round_solid.h"
#include "kerf/describe.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

enum class ExerciseKind { kGroove, kStopBeforeFar, kBicortical, kBesideCanal, kFollowLine, kOsteotomy, kDrillHoles };

/// Levels of difficulty.
inline constexpr int kLevels = 5;

/// Values of `kind` in [exercise], in the order of ExerciseKind.
inline constexpr std::array<std::string_view, 7> kExerciseKindWords{
    "groove", "stop_before_far", "bicortical", "beside_canal", "follow_line", "osteotomy", "drill_holes"};

/// Largest number of cuts in an exercise.
inline constexpr std::size_t kMaxExerciseCuts = 16;

/// A further cut or hole of an exercise: [[exercise.cut]].
struct SceneCut {
  Vec3 start_mm{0};
  Vec3 end_mm{10, 0, 0};
  Vec3 into{0, 0, -1};
  double depth_mm = 3;
  std::string place = {};  // of start_mm in the scene's file, "scene.toml:12:1", for messages; not a key
};

template <typename V>
void Describe(SceneCut& p, V&& visit) {
  visit("start_mm", p.start_mm, kCoordinateRange_mm, "start of the wanted cut, on the surface; the place of a hole");
  visit("end_mm", p.end_mm, kCoordinateRange_mm, "end of the wanted cut, on the surface; a hole has none");
  visit("into", p.into, kDirectionRange,
        "direction into the bone, any length but 0; the cut's plane contains it and the line; its component along the "
        "line is ignored");
  visit("depth_mm", p.depth_mm, Range{0.05, 200}, "depth of the cut below the surface, along the whole line");
}

struct SceneExercise {
  bool given = false;  // the file has the section; not a key
  ExerciseKind kind = ExerciseKind::kGroove;
  int level = 1;
  // The first wanted cut follows the line, which lies on the surface, to this depth below the surface.
  Vec3 start_mm{0};
  Vec3 end_mm{10, 0, 0};
  Vec3 into{0, 0, -1};
  double depth_mm = 3;
  std::string place = {};         // of start_mm in the scene's file, as of a SceneCut; not a key
  std::vector<SceneCut> further;  // the others, in their order; not a key
  double margin_mm = 0.5;
  double feed_mm_per_s = 2;
  double force_limit_N = 0;
  double time_limit_s = 0;
  // Aids.
  bool gauge = true;
  bool colour = true;
  bool sound = true;
  bool depth_stop = false;
};

template <typename V>
void Describe(SceneExercise& p, V&& visit) {
  std::string kind(kExerciseKindWords[static_cast<std::size_t>(p.kind)]);
  visit("kind", kind, Choices{{kExerciseKindWords.begin(), kExerciseKindWords.end()}},
        "kind of the exercise, which determines the scored measures: docs/practise.md");
  for (std::size_t i = 0; i < kExerciseKindWords.size(); ++i) {
    if (kind == kExerciseKindWords[i]) p.kind = static_cast<ExerciseKind>(i);
  }
  visit("level", p.level, Range{1, kLevels}, "level of difficulty: 1 has all aids; each further level removes one");
  SceneCut first{p.start_mm, p.end_mm, p.into, p.depth_mm, ""};
  Describe(first, visit);
  p.start_mm = first.start_mm;
  p.end_mm = first.end_mm;
  p.into = first.into;
  p.depth_mm = first.depth_mm;
  visit("margin_mm", p.margin_mm, Range{0.01, 20},
        "distance beside and below the wanted cut within which removed bone is not an error");
  visit("feed_mm_per_s", p.feed_mm_per_s, Range{0.1, 100}, "wanted feed rate along the line");
  visit("force_limit_N", p.force_limit_N, Range{0, 1000}, "maximum permitted force on the hand; 0: no limit");
  visit("time_limit_s", p.time_limit_s, Range{0, 3600}, "time after which the exercise ends; 0: no limit");
  visit("gauge", p.gauge, "aid: the depth is shown as a number and a bar");
  visit("colour", p.colour, "aid: the blade's colour shows the distance to the goal");
  visit("sound", p.sound, "aid: a tone indicates the distance to the goal");
  visit("depth_stop", p.depth_stop, "aid: the tool is held at the depth of the goal; only with one cut or hole");
}

/// The wanted cut in its own frame: s along the line from its start, t into the bone, w across the cut.
struct WantedCut {
  Vec3 start_W{0};
  Vec3 along_W{1, 0, 0};  // unit vectors
  Vec3 into_W{0, 0, -1};
  Vec3 across_W{0, 1, 0};  // normal of the cut's plane
  double length_mm = 0;    // 0: a hole
  double depth_mm = 0;
  double margin_mm = 0;
  /// Of the tool; of a blade with a stroke, half of the length of edge and stroke: how far the tool in the wanted cut
  /// reaches along the line from its middle.
  double radius_mm = 0;
  double edge_radius_mm = 0;  // of the edge that makes the floor; 0: straight
  double thickness_mm = 0;    // of the kerf: a blade's thickness, or another tool's diameter
  double reach_mm = 0;        // of the tool about its origin
  double below_mm = 0;        // depth of the tool's lowest point below its origin, in the pose of the wanted cut
  ToolForm form = ToolForm::kBlade;
  std::optional<RoundSolid> solid;  // the body of a tool of the form kRound
  ConvexOutline outline;            // of all that a blade with a stroke passes; empty for any other tool
  /// How often the tool goes down along the line, at equal distances: a blade with a stroke has no teeth on its sides.
  /// 1: it moves along the line at depth.
  int plunges = 1;

  CutPlane plane() const { return {start_W, across_W}; }
  /// Returns {s, t, w} of a world point.
  Vec3 ToCut(const Vec3& p_W) const {
    const Vec3 d = p_W - start_W;
    return {d.x * along_W.x + d.y * along_W.y + d.z * along_W.z, d.x * into_W.x + d.y * into_W.y + d.z * into_W.z,
            d.x * across_W.x + d.y * across_W.y + d.z * across_W.z};
  }
  Vec3 ToWorld(const Vec3& stw) const { return start_W + stw.x * along_W + stw.y * into_W + stw.z * across_W; }
  /// Returns the tool frame where the cut at `s_mm` has the depth `t_mm`: x along the cut, z across it, or out of the
  /// bone for a solid of revolution. Of a blade with a stroke, x points into the bone and y, the edge, along the cut.
  Pose CalcToolPose(double s_mm, double t_mm) const;
  /// Returns the tool's lowest point: the one furthest into the bone. A flat end or a straight edge changes its lowest
  /// point with the least tilt, so that of a solid of revolution or a blade with a stroke is returned at the place of
  /// its tip or its edge's middle.
  Vec3 FindLowest(const Pose& X_WT) const;
  /// Returns the angle between a blade, or the axis of a solid of revolution, and the cut's plane, or the axis of the
  /// hole; 0 for a ball.
  double CalcTilt_deg(const Pose& X_WT) const;
  /// Returns {s, t, w} of points of the tool's outline, in order around it: of a blade's rim, otherwise of the tool as
  /// seen across the cut.
  std::vector<Vec3> CalcOutline(const Pose& X_WT, int points) const;
  /// Returns how far the tool in the wanted cut reaches along the line from its lowest point, at a small height above
  /// it.
  double CalcReachAlong(double above_mm) const;
  /// Returns the depth of the floor that the tool leaves at a distance beyond the place where it stopped, at most its
  /// radius. Above the surface, it is negative.
  double CalcFloor(double beyond_mm) const;
  /// Returns the signed distance, mm, from the region that a tool removes if it makes exactly the wanted cut: its sweep
  /// along the line at full depth, and everything above that. Negative inside.
  double CalcDistance(const Vec3& p_W) const;
  /// Returns true within that region and its margin, where removed bone is not an error.
  bool IsNear(const Vec3& p_W) const { return CalcDistance(p_W) <= margin_mm; }

 private:
  /// The distance in the cut's plane from the part that a blade or a ball passes, at a distance beyond the line's ends.
  double CalcInPlane(double beyond_mm, double t_mm) const;
};

/// Returns the wanted cut of an exercise with only one, or the first one. Throws kerf::Error if the line has no length
/// or the direction into the bone is parallel to it.
WantedCut MakeWantedCut(const SceneExercise& exercise, const Tool& tool);
/// Returns all wanted cuts, in their order. Throws the same errors.
std::vector<WantedCut> MakeWantedCuts(const SceneExercise& exercise, const Tool& tool);

/// Returns true if both are the same line or hole in the same direction, to any depth.
bool IsSamePlace(const WantedCut& a, const WantedCut& b);

/// Returns the cut that a point is nearest to, by its signed distance. `cuts`: at least one.
const WantedCut& FindNearestCut(const std::vector<WantedCut>& cuts, const Vec3& p_W);

}  // namespace kerf
