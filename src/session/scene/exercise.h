// The section of a scene that makes it an exercise: the cut that is wanted, and what helps the student.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "base/core/describe.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

enum class ExerciseKind { kGroove, kStopBeforeFar, kBicortical, kBesideCanal, kFollowLine, kOsteotomy };

/// The words of `kind` in [exercise], in the order of ExerciseKind.
inline constexpr std::array<std::string_view, 6> kExerciseKindWords{"groove",       "stop_before_far", "bicortical",
                                                                    "beside_canal", "follow_line",     "osteotomy"};

struct SceneExercise {
  bool given = false;  // the file has the section; not a key
  ExerciseKind kind = ExerciseKind::kGroove;
  int level = 1;
  // The cut: along the line, which lies on the surface, and so deep below it.
  Vec3 start_mm{0};
  Vec3 end_mm{10, 0, 0};
  Vec3 into{0, 0, -1};
  double depth_mm = 3;
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
        "what is practised, and so what counts: docs/practise.md");
  for (std::size_t i = 0; i < kExerciseKindWords.size(); ++i) {
    if (kind == kExerciseKindWords[i]) p.kind = static_cast<ExerciseKind>(i);
  }
  visit("level", p.level, Range{1, 5}, "1: with all aids; each further one withdraws an aid");
  visit("start_mm", p.start_mm, Range{-kWorldReach_mm, kWorldReach_mm}, "where the wanted cut begins, on the surface");
  visit("end_mm", p.end_mm, Range{-kWorldReach_mm, kWorldReach_mm}, "where it ends, on the surface");
  visit("into", p.into, Range{-1000, 1000},
        "direction into the bone, of any length but 0; the cut's plane holds it and the line, and what of it is along "
        "the line does not count");
  visit("depth_mm", p.depth_mm, Range{0.05, 200}, "depth of the cut below the surface, all along the line");
  visit("margin_mm", p.margin_mm, Range{0.01, 20}, "beside and below the wanted cut, what is removed is no fault yet");
  visit("feed_mm_per_s", p.feed_mm_per_s, Range{0.1, 100}, "speed along the line that is wanted");
  visit("force_limit_N", p.force_limit_N, Range{0, 1000}, "force on the hand that is too much; 0: none is");
  visit("time_limit_s", p.time_limit_s, Range{0, 3600}, "the exercise ends then; 0: it does not");
  visit("gauge", p.gauge, "aid: the depth is shown as a number and a bar");
  visit("colour", p.colour, "aid: the blade's colour tells how near the goal is");
  visit("sound", p.sound, "aid: a tone tells it");
  visit("depth_stop", p.depth_stop, "aid: the tool is held where the goal is reached");
}

/// The wanted cut in a frame of its own: s along the line from its start, t into the bone, w across the cut.
struct WantedCut {
  Vec3 start_W{0};
  Vec3 along_W{1, 0, 0};  // unit vectors
  Vec3 into_W{0, 0, -1};
  Vec3 across_W{0, 1, 0};  // normal of the cut's plane
  double length_mm = 0;
  double depth_mm = 0;
  double margin_mm = 0;
  double radius_mm = 0;     // of the tool
  double thickness_mm = 0;  // of the kerf: the disc's, or a ball's diameter
  bool is_disc = true;

  CutPlane plane() const { return {start_W, across_W}; }
  /// {s, t, w} of a world point.
  Vec3 ToCut(const Vec3& p_W) const {
    const Vec3 d = p_W - start_W;
    return {d.x * along_W.x + d.y * along_W.y + d.z * along_W.z, d.x * into_W.x + d.y * into_W.y + d.z * into_W.z,
            d.x * across_W.x + d.y * across_W.y + d.z * across_W.z};
  }
  Vec3 ToWorld(const Vec3& stw) const { return start_W + stw.x * along_W + stw.y * into_W + stw.z * across_W; }
  /// The tool frame as it is where the cut at `s_mm` is `t_mm` deep: z across the cut, x along it.
  Pose CalcToolPose(double s_mm, double t_mm) const;
  /// mm from what a tool removes that makes the wanted cut exactly: its way along the line at full depth, and all above
  /// that. Negative inside.
  double CalcDistance(const Vec3& p_W) const;
};

/// Throws Error when the line has no length or the direction into the bone lies along it.
WantedCut MakeWantedCut(const SceneExercise& exercise, const Tool& tool);

}  // namespace kerf
