// Tests of a hand that lets go of the tool, and of a tool that is moved out of the bone: by undo, redo and retracting.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bone/grid/removed.h"
#include "bone/models/block.h"
#include "kerf/error.h"
#include "loop/haptics/mouse_hand.h"
#include "session/run/clear_pose.h"
#include "session/run/make_bone.h"
#include "session/run/run_loop.h"
#include "support/block_scene.h"
#include "support/folder.h"
#include "support/solids.h"

namespace kerf {
namespace {

/// A mouse whose user follows a script: the aim at a time; nullopt: the mouse is not moved.
class ScriptedMouse final : public HandDriver {
 public:
  using Script = std::function<std::optional<HandAim>(double time_s)>;
  ScriptedMouse(SimulatedDevice& device, const Pose& X_WH, const Vec3& p_TC_mm, Script script)
      : script_(std::move(script)), target_({X_WH, false}), hand_(device, target_, X_WH, p_TC_mm) {}
  void Advance(double dt_s) noexcept override {
    time_s_ += dt_s;
    if (const std::optional<HandAim> aim = script_(time_s_)) target_.Publish(*aim);
    hand_.Advance(dt_s);
  }
  void Follow(const Pose& X_WT, bool touches, bool turns) noexcept override { hand_.Follow(X_WT, touches, turns); }
  bool can_place() const override { return true; }
  void Place(const Pose& X_WH) noexcept override { hand_.Place(X_WH); }

 private:
  double time_s_ = 0;
  Script script_;
  HandTarget target_;
  MouseHand hand_;
};

/// As ParseLoopAction(), and "TIME:retract".
LoopAction MakeAction(const std::string& text) {
  const std::size_t word = text.find(":retract");
  if (word == std::string::npos) return ParseLoopAction(text);
  return {.at_s = std::stod(text.substr(0, word)), .kind = LoopAction::Kind::kRetract, .name = ""};
}

/// A session with a bar whose top is at z = 0 and a disc of 12 mm above it.
class MovedTool : public ::testing::Test {
 protected:
  static Scene MakeScene(double start_mm = 6.5) {
    return ParseScene(test::kBarToml + test::StrokeToml({0, 0, start_mm}, {0, 0, start_mm - 1}, 3, {1, 0, 0}) +
                          "[hand]\nmodel = \"H4\"\n[device]\nprofile = \"omega_6\"\n[force]\nlaw = \"hertz_chip\"\n",
                      "/tmp/s.toml");
  }

  /// Runs the scene with a scripted mouse and keeps the ticks; afterwards checks that the replay is bit-identical.
  LoopSummary Run(const Scene& scene, double seconds, const ScriptedMouse::Script& script,
                  const std::vector<std::string>& actions = {}) {
    const std::string path = fmt::format("{}/{}.kerf", own_.path(), ++runs_);
    LoopOptions options;
    options.virtual_time = true;
    options.seconds = seconds;
    options.output.record = path;
    options.output.scene_file = "/tmp/s.toml";
    options.output.keep_bones = true;
    for (const std::string& action : actions) {
      options.undo.actions.push_back(MakeAction(action));
      options.undo.actions.back().X_to = X_to_;
    }
    options.driver.make_hand = [&](SimulatedDevice& device, const LoopSetup&, const Vec3& p_TC_mm, double) {
      DeviceSample sample;
      device.Read(sample);
      return std::make_unique<ScriptedMouse>(device, sample.X_WH, p_TC_mm, script);
    };
    ticks_.clear();
    options.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) { ticks_.push_back(tick); };
    LoopSummary s = RunLoop(scene, options, {});
    EXPECT_TRUE(s.mirror_identical);

    RecordingReader recording(path);
    const RecordedScene recorded = OpenRecordedScene(recording, "");
    LoopOptions replay;
    replay.virtual_time = true;
    replay.replay = {&recording, 1e9, false, true, 0};
    const Replayed replayed = *RunLoop(recorded.scene, replay, {}).replayed;
    EXPECT_FALSE(replayed.divergence) << replayed.divergence->what << " at " << replayed.divergence->time_s;
    EXPECT_EQ(replayed.steps, ticks_.size());
    EXPECT_EQ(replayed.bone_hash, s.bone_hash);
    return s;
  }
  const LoopTick& At(double time_s) const { return ticks_[static_cast<std::size_t>(1000 * time_s)]; }
  double SumRemoved(double from_s, double to_s) const {
    double mm3 = 0;
    for (auto i = static_cast<std::size_t>(1000 * from_s); i < static_cast<std::size_t>(1000 * to_s); ++i) {
      mm3 += ticks_[i].coupled.removed_mm3;
    }
    return mm3;
  }

  test::Folder own_;
  std::optional<Pose> X_to_;  // of retracting
  int runs_ = 0;
  std::vector<LoopTick> ticks_;
};

const Quat kDiscAlongX = glm::angleAxis(std::numbers::pi / 2, Vec3(0, 1, 0));

/// The user drags the saw down from 0.1 s on and lets go at `until_s`.
ScriptedMouse::Script DragDown(double until_s, double to_mm = -4) {
  return [=](double time_s) -> std::optional<HandAim> {
    if (time_s < 0.1) return std::nullopt;
    const Pose X{kDiscAlongX, {0, 0, 6.5 + (to_mm - 6.5) * std::min(1.0, (time_s - 0.1) / 0.3)}};
    return HandAim{X, time_s < until_s};
  };
}

// Without letting go, the hand's spring pulls the saw through the whole bar.
TEST_F(MovedTool, StopsCuttingWhenTheUserLetsGo) {
  for (const double until_s : {0.5, 0.7}) {
    Run(MakeScene(), 3, DragDown(until_s));
    const double depth_mm = 6 - At(until_s).coupled.X_WT.p_AB.z;
    ASSERT_GT(depth_mm, 0.2);
    ASSERT_LT(depth_mm, 2.5);
    ASSERT_GT(glm::length(At(until_s - 0.01).coupled.f_H_W_N), 0.5);  // the hand pulls
    // The saw stays where it is, apart from the 10 ms before the release at less than 4 mm/s and two steps of the
    // encoder, and cuts as much as that: a blade of 0.5 mm removes 0.5 mm x 4 mm of each millimetre.
    EXPECT_LT(glm::distance(ticks_.back().coupled.X_WT.p_AB, At(until_s - 0.01).coupled.X_WT.p_AB), 0.06);
    EXPECT_LT(SumRemoved(until_s - 0.01, 3), 0.12);
    // What the relaxing coupling still presses, less than 0.05 N, may cut a hundredth of a millimetre.
    EXPECT_LT(SumRemoved(until_s + 0.1, 3), 0.02);
    EXPECT_LT(glm::length(ticks_.back().coupled.f_H_W_N), 0.05);
  }
  Run(MakeScene(), 3, DragDown(10));
  EXPECT_GT(6 - ticks_.back().coupled.X_WT.p_AB.z, 3.5);
}

TEST_F(MovedTool, StopsTurningWhenTheUserLetsGo) {
  Run(MakeScene(), 2, [](double time_s) -> std::optional<HandAim> {
    HandAim aim = *DragDown(0.5)(std::max(time_s, 0.1));
    if (time_s > 0.45) aim.X_WH.R_AB = glm::normalize(glm::angleAxis(0.3, Vec3(0, 0, 1)) * kDiscAlongX);
    aim.holds = time_s < 0.6;
    return aim;
  });
  const double before_Nmm = glm::length(At(0.59).coupled.tau_H_W_Nmm);
  ASSERT_GT(before_Nmm, 100);
  EXPECT_LT(glm::length(ticks_.back().coupled.f_H_W_N), 0.05);
  EXPECT_LT(glm::length(ticks_.back().coupled.tau_H_W_Nmm), 0.05 * before_Nmm);
  EXPECT_LT(glm::distance(ticks_.back().coupled.X_WT.p_AB, At(0.59).coupled.X_WT.p_AB), 0.06);
  EXPECT_LT(SumRemoved(0.7, 2), 0.02);
}

// In air, a motion that was under way ends within the distance that MouseHandParams permits.
TEST_F(MovedTool, CompletesOnlyAShortMotionInAir) {
  Run(MakeScene(), 1.5, [](double time_s) -> std::optional<HandAim> {
    return HandAim{{kDiscAlongX, {0, 0, time_s < 0.2 ? 6.5 : 20}}, time_s < 0.25};
  });
  const double after_mm = ticks_.back().coupled.X_WT.p_AB.z - At(0.25).coupled.X_WT.p_AB.z;
  EXPECT_GT(At(0.25).coupled.X_WT.p_AB.z, 6.6);
  EXPECT_LT(after_mm, MouseHandParams{}.coast_mm + 0.1);  // and the encoder's steps
}

TEST_F(MovedTool, UndoAndRedoBringTheSawBackToItsPoseThen) {
  const Scene scene = MakeScene();
  const Tool tool = MakeTool(scene);
  const LoopSummary s =
      Run(scene, 3, DragDown(0.6), {"0.8:rpm=0", "0.9:checkpoint=cut", "1:undo=start", "1.5:redo", "2:undo=start"});
  ASSERT_EQ(s.undo->restores, 3u);
  ASSERT_GT(SumRemoved(0, 0.9), 0.5);
  const Pose X_start = MakePath(scene).CalcPose(0, 0);
  const Pose X_cut = At(0.99).coupled.X_WT;
  ASSERT_LT(X_cut.p_AB.z, 5.8);
  // The handle is quantised by the encoder.
  EXPECT_LT(glm::distance(At(1.4).coupled.X_WT.p_AB, X_start.p_AB), 0.03);
  EXPECT_LT(glm::distance(At(1.9).coupled.X_WT.p_AB, X_cut.p_AB), 0.1);
  EXPECT_LT(glm::distance(At(2.9).coupled.X_WT.p_AB, X_start.p_AB), 0.03);
  EXPECT_EQ(SumRemoved(0.9, 3), 0);
  EXPECT_EQ(s.after.CalcHash(), s.before.CalcHash());
  // While the simulation runs, the saw is never in the restored bone.
  const PhiSampler whole(s.before);
  for (std::size_t i = 1000; i < 1500; ++i) {
    if (ticks_[i].stands) continue;
    EXPECT_TRUE(IsClear(whole, tool, ticks_[i].coupled.X_WT, 0)) << i;
    EXPECT_EQ(ticks_[i].coupled.f_face_W_N, Vec3(0)) << i;
  }
}

// With the guide on, the saw was turned into the plane after the start, and cuts there. The undo to the start does not
// turn it back: it keeps its attitude and stands above the bone, in the plane.
TEST_F(MovedTool, UndoKeepsTheAttitudeInTheGuidesPlane) {
  const auto make = [](bool guided) {
    return ParseScene(test::kBarToml + test::StrokeToml({0, 0, 8}, {0, 0, 7}, 3, {0, 1, 0}) +
                          "[hand]\nmodel = \"H4\"\n[device]\nprofile = \"omega_6\"\n" +
                          (guided ? "[effects.guide]\npoint_mm = [0.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n"
                                    "depth_direction = [0.0, 0.0, -1.0]\ntolerance_mm = 0.1\n"
                                  : ""),
                      "/tmp/s.toml");
  };
  const auto turn_and_cut = [](double time_s) -> std::optional<HandAim> {
    if (time_s < 0.1) return std::nullopt;
    const double down = std::clamp((time_s - 0.5) / 0.4, 0.0, 1.0);
    return HandAim{{kDiscAlongX, {0, 0, 8 - 10 * down}}, time_s < 1.4};
  };
  for (const bool guided : {true, false}) {
    const Scene scene = make(guided);
    const LoopSummary s = Run(scene, 2.5, turn_and_cut, {"1.5:rpm=0", "1.7:undo=start"});
    ASSERT_EQ(s.undo->restores, 1u);
    ASSERT_GT(SumRemoved(0, 1.5), 0.5);
    const Pose& X_end = ticks_.back().coupled.X_WT;
    const double along = std::abs(X_end.Vector({0, 0, 1}).x);
    EXPECT_TRUE(IsClear(PhiSampler(s.after), MakeTool(scene), X_end, 0));
    EXPECT_EQ(SumRemoved(1.5, 2.5), 0);
    if (guided) {
      EXPECT_GT(along, std::cos(0.05));  // 0.1 mm at the rim of 6 mm, and the guide gives way a little
      EXPECT_NEAR(X_end.p_AB.x, 0, 0.2);
      EXPECT_LT(X_end.p_AB.z, 7.5);  // above the bar by the voxels of the margin, and half a millimetre of a step
    } else {
      EXPECT_LT(along, 0.1);  // as it was at the start
    }
  }
}

// The saw was in its own kerf when the checkpoint was made, and it returns there.
TEST_F(MovedTool, ReturnsIntoItsKerf) {
  const LoopSummary s = Run(MakeScene(), 2.5,
                            [](double time_s) -> std::optional<HandAim> {
                              if (time_s < 1) return DragDown(0.5)(time_s);
                              return HandAim{{kDiscAlongX, {0, 0, -6}}, time_s > 1.2 && time_s < 1.4};
                            },
                            {"0.9:checkpoint=deep", "1.5:rpm=0", "1.7:undo=deep"});
  ASSERT_EQ(s.undo->restores, 1u);
  ASSERT_GT(SumRemoved(1.2, 1.5), 0.1);
  EXPECT_LT(glm::distance(ticks_.back().coupled.X_WT.p_AB, At(0.9).coupled.X_WT.p_AB), 0.1);
  EXPECT_EQ(SumRemoved(1.7, 2.5), 0);
}

TEST_F(MovedTool, RetractsAlongTheWayItCame) {
  const Scene scene = MakeScene();
  const LoopSummary s = Run(scene, 3, DragDown(0.7), {"0.9:rpm=0", "1:retract"});
  const PhiSampler after(s.after);
  EXPECT_FALSE(IsClear(after, MakeTool(scene), At(0.99).coupled.X_WT, 0.1));
  EXPECT_TRUE(IsClear(after, MakeTool(scene), ticks_.back().coupled.X_WT, 0.2));
  EXPECT_EQ(SumRemoved(0.99, 3), 0);
  for (std::size_t i = 1000; i < ticks_.size(); ++i) {
    const Vec3& p = ticks_[i].coupled.X_WT.p_AB;
    EXPECT_LT(std::hypot(p.x, p.y), 0.1) << i;  // straight up, as it came down
    // No jump: 40 mm/s for 1 ms, and the encoder's steps.
    EXPECT_LT(glm::distance(p, ticks_[i - 1].coupled.X_WT.p_AB), 0.1) << i;
    EXPECT_LT(glm::length(ticks_[i].force.f_H_W_N), 0.1) << i;
  }
}

// From the bone the saw goes on to the wanted place, and jumps if bone is in the way there.
TEST_F(MovedTool, RetractsToAPlace) {
  const Scene scene = MakeScene();
  for (const Vec3& to : {Vec3{3, 5, 14}, Vec3{0, 0, -30}}) {
    X_to_ = {kDiscAlongX, to};
    const LoopSummary s = Run(scene, 4, DragDown(0.7), {"0.9:rpm=0", "1:retract"});
    const PhiSampler after(s.after);
    EXPECT_LT(glm::distance(ticks_.back().coupled.X_WT.p_AB, to), 0.1);
    EXPECT_EQ(SumRemoved(0.99, 4), 0);
    for (std::size_t i = 1000; i < ticks_.size(); ++i) {
      const bool in_bone = !IsClear(after, MakeTool(scene), ticks_[i].coupled.X_WT, -0.3);
      ASSERT_FALSE(in_bone) << to.z << ": " << i;
    }
  }
  // A place in bone stands for one beside it.
  X_to_ = {kDiscAlongX, {0, 0, 1}};
  const LoopSummary s = Run(scene, 4, DragDown(0.7), {"0.9:rpm=0", "1:retract"});
  EXPECT_TRUE(IsClear(PhiSampler(s.after), MakeTool(scene), ticks_.back().coupled.X_WT, 0));
  X_to_.reset();
}

// Each checkpoint without a name, such as the window makes after each stroke, is one step of undo, and undo and redo
// say how much bone they have restored.
TEST_F(MovedTool, UndoesStrokesOneByOneAndSaysTheirVolumes) {
  struct Peer final : SessionController {
    void Begin(const LoopInitialState& /*initial*/) override {}
    void TakeLeaf(const LeafMessage& /*leaf*/) override {}
    std::optional<LoopAction> NextAction() override {
      using Kind = LoopAction::Kind;
      if (next < actions.size() && *time_s >= actions[next].first) {
        const Kind kind = actions[next++].second;
        return LoopAction{.kind = kind, .name = ""};
      }
      return std::nullopt;
    }
    void Done(const LoopAction& action, const std::string& failure, std::optional<double> restored_mm3) override {
      EXPECT_EQ(failure, "");
      if (action.kind != LoopAction::Kind::kCheckpoint) restored.push_back(restored_mm3.value_or(-1));
    }
    const double* time_s = nullptr;
    std::vector<std::pair<double, LoopAction::Kind>> actions;
    std::size_t next = 0;
    std::vector<double> restored;
  };
  using Kind = LoopAction::Kind;
  Peer peer;
  double time_s = 0;
  peer.time_s = &time_s;
  peer.actions = {
      {1.2, Kind::kCheckpoint}, {2.5, Kind::kCheckpoint}, {2.8, Kind::kUndo}, {3.2, Kind::kUndo}, {3.6, Kind::kRedo}};
  LoopOptions options;
  options.virtual_time = true;
  options.seconds = 4;
  options.watchers.peer = &peer;
  double first_mm3 = 0, second_mm3 = 0;
  options.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) {
    time_s = tick.time_s;
    (time_s < 1.2 ? first_mm3 : second_mm3) += tick.coupled.removed_mm3;
  };
  options.driver.make_hand = [&](SimulatedDevice& device, const LoopSetup&, const Vec3& p_TC_mm, double) {
    DeviceSample sample;
    device.Read(sample);
    return std::make_unique<ScriptedMouse>(device, sample.X_WH, p_TC_mm, [](double at_s) -> std::optional<HandAim> {
      if (at_s < 1.3) return DragDown(0.5)(at_s);
      return HandAim{{kDiscAlongX, {0, 0, -6}}, at_s < 2.2};
    });
  };
  RunLoop(MakeScene(), options, {});
  ASSERT_EQ(peer.restored.size(), 3u);
  ASSERT_GT(first_mm3, 0.5);
  ASSERT_GT(second_mm3, 0.5);
  EXPECT_NEAR(peer.restored[0], second_mm3, 0.02 * second_mm3);
  EXPECT_NEAR(peer.restored[1], first_mm3, 0.02 * first_mm3);
  EXPECT_NEAR(peer.restored[2], first_mm3, 0.02 * first_mm3) << "redone";
}

// A saw that was placed inside a bone has no way back. It is lifted out in the blade's plane.
TEST_F(MovedTool, RetractsABuriedSawStraightOut) {
  const Scene scene = MakeScene(4);
  const std::string path = own_.path() + "/buried.kerf";
  LoopOptions options;
  options.virtual_time = true;
  options.seconds = 2;
  options.output.keep_bones = true;
  for (const char* action : {"0:rpm=0", "0.2:retract"}) options.undo.actions.push_back(MakeAction(action));
  options.driver.make_hand = [&](SimulatedDevice& device, const LoopSetup&, const Vec3& p_TC_mm, double) {
    DeviceSample sample;
    device.Read(sample);
    return std::make_unique<ScriptedMouse>(device, sample.X_WH, p_TC_mm, [](double) { return std::nullopt; });
  };
  Pose X_end;
  options.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) { X_end = tick.coupled.X_WT; };
  const LoopSummary s = RunLoop(scene, options, {});
  ASSERT_TRUE(s.starts_in_bone);
  EXPECT_TRUE(IsClear(PhiSampler(s.after), MakeTool(scene), X_end, 0.2));
  EXPECT_NEAR(X_end.p_AB.x, 0, 0.05);
  EXPECT_EQ(s.removed_mm3, 0);
}

TEST_F(MovedTool, HandThatFollowsAPathIsNotRetracted) {
  LoopOptions options;
  options.virtual_time = true;
  options.seconds = 0.5;
  options.undo.actions.push_back(MakeAction("0.2:retract"));
  const LoopSummary s = RunLoop(MakeScene(), options, {});
  ASSERT_FALSE(s.warnings.empty());
  EXPECT_NE(s.warnings.back().find("can't be retracted"), std::string::npos) << s.warnings.back();
}

TEST(IsClear, AgreesWithTheGeometryOfABlock) {
  const Scene scene = ParseScene(test::MakeBlockScene(), "/tmp/s.toml");
  const Bone bone = MakeSceneBone(scene, {});
  const PhiSampler phi(bone);
  const Tool tool = MakeTool(scene);
  // The disc has a radius of 6 mm and its axis along x. Its lowest point is 6 mm below its centre, and the block's top
  // is at z = 0. The disc's points are less than half a voxel from the exact lowest one.
  for (const double gap_mm : {-0.3, -0.1, 0.1, 0.3}) {
    const Pose X{kDiscAlongX, {0, 0, 6 + gap_mm}};
    EXPECT_EQ(IsClear(phi, tool, X, 0), gap_mm > 0) << gap_mm;
    EXPECT_TRUE(IsClear(phi, tool, X, gap_mm - 0.1)) << gap_mm;
    EXPECT_FALSE(IsClear(phi, tool, X, gap_mm + 0.1)) << gap_mm;
  }
  // The block is 6 mm long: sideways, the flat at 0.25 mm from the middle counts.
  EXPECT_TRUE(IsClear(phi, tool, {kDiscAlongX, {3.3, 0, 0}}, 0));
  EXPECT_FALSE(IsClear(phi, tool, {kDiscAlongX, {3.2, 0, 0}}, 0));
  EXPECT_FALSE(IsClear(phi, BallBurr{}, {Quat{1, 0, 0, 0}, {0, 0, 2.9}}, 0));
  EXPECT_TRUE(IsClear(phi, BallBurr{}, {Quat{1, 0, 0, 0}, {0, 0, 3.1}}, 0));

  // In the blade's plane the nearest way out of the middle is up or down: 3 mm of bone, of which the centre is at 1.5
  // mm.
  const Pose X = FindNearestClearPose(phi, tool, {kDiscAlongX, {0, 0, -1}}, {0, 0, -1.5}, 0.1, 30);
  EXPECT_TRUE(IsClear(phi, tool, X, 0.1));
  EXPECT_NEAR(X.p_AB.x, 0, 1e-9);
  EXPECT_NEAR(glm::length(X.p_AB - Vec3(0, 0, -1)), 7.5, 1);
}

TEST(ToolTrail, FindsTheWayBackWithoutDetours) {
  const Scene scene = ParseScene(test::MakeBlockScene(), "/tmp/s.toml");
  const Bone bone = MakeSceneBone(scene, {});
  const PhiSampler phi(bone);
  ToolTrail trail;
  double z = 7;
  const auto go_to = [&](double to) {
    for (; std::abs(z - to) > 1e-9; z += std::clamp(to - z, -0.01, 0.01)) trail.Take({kDiscAlongX, {0, 0, z}});
  };
  go_to(4);
  for (int i = 0; i < 10; ++i) go_to(i % 2 == 0 ? 5.5 : 3);  // to and fro in the bone
  const Pose X_now{kDiscAlongX, {0, 0, z}};
  const std::vector<Pose> way = trail.FindWayBack(phi, MakeTool(scene), X_now, 0.1);
  ASSERT_FALSE(way.empty());
  EXPECT_EQ(way.front().p_AB, X_now.p_AB);
  EXPECT_TRUE(IsClear(phi, MakeTool(scene), way.back(), 0.1));
  double length_mm = 0;
  for (std::size_t i = 1; i < way.size(); ++i) length_mm += glm::distance(way[i - 1].p_AB, way[i].p_AB);
  EXPECT_LT(length_mm, std::abs(way.back().p_AB.z - z) + 4 * ToolTrail::kStep_mm);

  // After a jump, the way before it is forgotten.
  trail.Take({kDiscAlongX, {0, 0, -1}});
  EXPECT_EQ(trail.poses().size(), 1u);
  EXPECT_TRUE(trail.FindWayBack(phi, MakeTool(scene), {kDiscAlongX, {0, 0, -1}}, 0.1).empty());
}

TEST(DivideIntoTicks, MovesAtTheSpeed) {
  const std::vector<Pose> corners{
      {Quat{1, 0, 0, 0}, {0, 0, 0}}, {Quat{1, 0, 0, 0}, {3, 4, 0}}, {glm::angleAxis(0.5, Vec3(0, 0, 1)), {3, 4, 0}}};
  const std::vector<Pose> poses = DivideIntoTicks(corners, 10, 0.001, 6);
  // 5 mm of translation and 0.5 rad x 6 mm of rotation, at 0.01 mm per tick; each part is rounded up.
  EXPECT_NEAR(static_cast<double>(poses.size()), 800, 2);
  EXPECT_EQ(poses.back().p_AB, corners.back().p_AB);
  EXPECT_NEAR(std::abs(glm::dot(poses.back().R_AB, corners.back().R_AB)), 1, 1e-12);
  EXPECT_TRUE(DivideIntoTicks({}, 10, 0.001, 6).empty());
}

TEST(ClearWay, LeadsAroundTheBone) {
  const Bone bone = test::MakeSphere({0, 0, 0}, 10, 0.5);
  const PhiSampler phi(bone);
  const Tool tool = DiscSaw{};
  const Pose X_left{{1, 0, 0, 0}, {25, 0, 0}};
  const Pose X_right{glm::angleAxis(1.2, Vec3(0, 1, 0)), {-25, 3, 2}};
  const auto find = [&](const Pose& from, const Pose& to) {
    return FindClearWay(phi, tool, from, to, {0, 0, 0}, 0, 60);
  };
  EXPECT_EQ(find(X_left, {X_left.R_AB, {25, 10, 0}}).size(), 1u);  // nothing is in the way
  std::vector<Pose> way = find(X_left, X_right);
  ASSERT_EQ(way.size(), 3u);
  EXPECT_EQ(way.back().p_AB, X_right.p_AB);
  EXPECT_EQ(way.back().R_AB, X_right.R_AB);
  way.insert(way.begin(), X_left);
  for (const Pose& X : DivideIntoTicks(way, 0.5, 1, CalcReach(tool))) {
    EXPECT_TRUE(IsClear(phi, tool, X, -0.5)) << X.p_AB.x << ' ' << X.p_AB.z;
  }
  // The direct way is blocked.
  const std::vector<Pose> direct = DivideIntoTicks({X_left, X_right}, 0.5, 1, CalcReach(tool));
  EXPECT_FALSE(std::all_of(direct.begin(), direct.end(), [&](const Pose& X) { return IsClear(phi, tool, X, 0); }));
  EXPECT_TRUE(find({{1, 0, 0, 0}, {15, 0, 0}}, X_right).empty());  // begins in the bone
}

}  // namespace
}  // namespace kerf
