// Tests of an attempt beside the expert's.
#include "session/practise/replay_pair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bone/models/block.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "small_exercise.h"

namespace kerf {
namespace {

/// Returns a track at constant velocity and turning rate, in contact from 3 to 5 s.
ToolTrack MakeUniformTrack() {
  ToolTrack track;
  LoopTick tick;
  for (int i = 0; i <= 8000; ++i) {
    tick.number = static_cast<std::uint64_t>(i) + 1;
    tick.time_s = 0.001 * i;
    tick.coupled.X_WT.p_AB = {2 * tick.time_s, 0, 1};
    tick.coupled.X_WT.R_AB = glm::angleAxis(0.1 * tick.time_s, Vec3(0, 0, 1));
    tick.coupled.engaged_teeth = tick.time_s >= 3 && tick.time_s < 5 ? 1 : 0;
    tick.in.rpm = 1000 * tick.time_s;
    track.Take(tick);
  }
  return track;
}

TEST(ToolTrack, KeepsOnePointPerStepAndInterpolatesBetweenThem) {
  const ToolTrack track = MakeUniformTrack();
  EXPECT_NEAR(track.duration_s(), 8, kTrackStep_s);
  EXPECT_NEAR(static_cast<double>(track.points().size()), 8 / kTrackStep_s, 2);
  for (const double t : {0.0, 0.013, 1.2345, 6.7}) {
    const TrackPoint p = track.Calc(t);
    EXPECT_NEAR(p.X_WT.p_AB.x, 2 * t, 1e-9);
    EXPECT_NEAR(2 * std::asin(p.X_WT.R_AB.z), 0.1 * t, 1e-9);  // slerp is exact at a constant turning rate
    EXPECT_NEAR(p.rpm, 1000 * t, 1e-6);
  }
  EXPECT_NEAR(track.Calc(-1).X_WT.p_AB.x, 0, 1e-12);
  EXPECT_EQ(track.Calc(100).time_s, track.duration_s());
}

TEST(ToolTrack, IsTrimmedToTheContactAndASecondAround) {
  const ToolTrack trimmed = MakeUniformTrack().Trim();
  EXPECT_EQ(trimmed.points().front().time_s, 0);
  EXPECT_NEAR(trimmed.duration_s(), 4, 3 * kTrackStep_s);
  EXPECT_NEAR(trimmed.Calc(0).X_WT.p_AB.x, 2 * 2.0, 4 * kTrackStep_s);
  ToolTrack no_contact;
  LoopTick tick;
  no_contact.Take(tick);
  EXPECT_EQ(no_contact.Trim().points().size(), 1U);
}

TEST(ReplayPair, ExpertReachesTheDepthAndFollowsTheLine) {
  const Scene scene = test::MakeSmallExercise("groove");
  const ToolTrack expert = MakeExpertTrack(scene);
  const WantedCut cut = MakeWantedCut(scene.exercise, MakeTool(scene));
  const DepthGauge gauge(MakeSceneBone(scene, {}), cut);
  const ReplayPair pair = MakeReplayPair(expert, expert, {&gauge, 1});
  ASSERT_FALSE(pair.expert_line_W.empty());
  // The expert's errors: an offset of 0.15 mm by 1.2 times at most, half a degree, and the tremor.
  double s_lower_mm = 1e9, s_upper_mm = -1e9;
  for (const Vec3& p_W : pair.expert_line_W) {
    const Vec3 p = cut.ToCut(p_W);
    EXPECT_LT(std::abs(p.z), 0.5);
    EXPECT_LT(p.y, cut.depth_mm + 0.4);
    s_lower_mm = std::min(s_lower_mm, p.x);
    s_upper_mm = std::max(s_upper_mm, p.x);
  }
  EXPECT_NEAR(s_lower_mm, 0, 0.5);
  EXPECT_NEAR(s_upper_mm, cut.length_mm, 0.5);
  double deepest_mm = 0;
  for (const DepthPoint& p : pair.expert_depth) deepest_mm = std::max(deepest_mm, p.depth_mm);
  EXPECT_NEAR(deepest_mm, cut.depth_mm, 0.3);
  EXPECT_EQ(pair.student_line_W, pair.expert_line_W);
  EXPECT_GT(pair.duration_s(), cut.length_mm / scene.exercise.feed_mm_per_s);
}

// Two cuts in a block: each point has the depth in its own.
TEST(ReplayPair, DepthIsThatInTheNearestCut) {
  SceneExercise exercise;
  exercise.kind = ExerciseKind::kOsteotomy;
  exercise.start_mm = {-8, -3, 0};
  exercise.end_mm = {8, -3, 0};
  exercise.depth_mm = 2;
  exercise.further.push_back({.start_mm = {-8, 3, 0}, .end_mm = {8, 3, 0}, .into = {0, 0, -1}, .depth_mm = 4});
  BlockParams block;
  block.size_mm = {20, 12, 6};
  block.voxel_mm = 0.25;
  const Bone bone = MakeBlock(block);
  std::vector<DepthGauge> gauges;
  for (const WantedCut& cut : MakeWantedCuts(exercise, DiscSaw{})) gauges.emplace_back(bone, cut);
  ToolTrack track;
  LoopTick tick;
  for (int i = 0; i < 400; ++i) {
    const std::size_t cut = i < 200 ? 0 : 1;
    tick.time_s = 0.01 * i;
    tick.coupled.X_WT = gauges[cut].cut().CalcToolPose(8, cut == 0 ? 1.5 : 3.5);
    tick.coupled.engaged_teeth = 1;
    track.Take(tick);
    EXPECT_EQ(&FindNearestGauge(gauges, tick.coupled.X_WT), &gauges[cut]) << i;
  }
  const ReplayPair pair = MakeReplayPair(track, track, gauges);
  ASSERT_GT(pair.student_depth.size(), 100U);
  // The surface is found by interpolation of a level set that is exact on a flat face.
  EXPECT_NEAR(pair.student_depth.front().depth_mm, 1.5, 0.01);
  EXPECT_NEAR(pair.student_depth.back().depth_mm, 3.5, 0.01);
}

TEST(ExpertTracks, AreMadeOnce) {
  Scene scene = test::MakeSmallExercise("groove");
  ExpertTracks tracks;
  const auto first = tracks.Get(scene);
  EXPECT_EQ(tracks.Get(scene), first);
  const std::atomic<bool> stop{true};
  scene.exercise.level = 2;
  EXPECT_THROW(tracks.Get(scene, &stop), Error);
}

}  // namespace
}  // namespace kerf
