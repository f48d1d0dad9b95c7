// Tests what the public headers offer to other programs: bones, scenes, runs, recordings, checkpoints, devices, and
// force laws and effects that a program adds.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "kerf/bone_file.h"
#include "kerf/checkpoints.h"
#include "kerf/error.h"
#include "kerf/import.h"
#include "kerf/label_map.h"
#include "kerf/models.h"
#include "kerf/own_effect.h"
#include "kerf/recording.h"
#include "kerf/run.h"
#include "kerf/surface.h"
#include "kerf/tick_warnings.h"
#include "kerf/version.h"
#include "support/folder.h"
#include "support/forge_recording.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::MessageOf;
using ::testing::HasSubstr;

/// A block of 12 x 6 x 6 mm; a slot 2 mm deep.
constexpr const char* kScene = R"(
[bone]
model = "block"

[bone.block]
size_x_mm = 12
size_y_mm = 6
size_z_mm = 6
voxel_mm = 0.2

[tool]
diameter_mm = 10
thickness_mm = 0.5

[[path.stroke]]
start_mm = [-12, 0, 3]
end_mm = [0, 0, 3]
feed_mm_per_s = 20
disc_normal = [0, 1, 0]

[hand]
push_N = 5
)";

// ---- bones

TEST(LabelMap, BoxHasItsVolumeWithTheEdgesOfTheInterpolatedSurface) {
  const int n = 20;
  const std::vector<std::uint8_t> labels(n * n * n, 7);
  const double spacing_mm = 0.5;
  const Bone bone = MakeBoneFromLabels(
      {.size = {n, n, n}, .spacing_mm = Vec3(spacing_mm), .X_WL = {}, .labels = labels}, {{7, 24}}, 0.1);
  // At an edge, the surface u v = 1/2 of the interpolated occupancy cuts off 1/4 - (1/2 - ln(2)/2) of a voxel's
  // cross-section; between the faces' voxel centres the edges are n - 1 voxels long. Each of the eight corners lies
  // within an eighth of a voxel, of which the surface x y z = 1/2 leaves at least nothing.
  const double edge = 0.25 - 0.5 * (1 - std::numbers::ln2);
  const double voxels = std::pow(n, 3) - 12 * (n - 1) * edge - 8 * 0.125;
  const double corners = 8 * 0.125;
  const double volume = bone.CalcVolume() / std::pow(spacing_mm, 3);
  EXPECT_GT(volume, voxels - 2);  // 2 voxels of 8000: what voxels of 0.1 mm lose at the sharper corners
  EXPECT_LT(volume, voxels + corners + 2);
  // The faces lie half a voxel beyond the last voxel centres.
  const Box3 box = bone.CalcBounds();
  EXPECT_NEAR(box.lower.x, -0.25, 0.01);
  EXPECT_NEAR(box.upper.z, (n - 0.5) * spacing_mm, 0.01);
}

TEST(LabelMap, RegionsSpacingsAndPoseAreHonoured) {
  // Two halves along x, in a lattice with three spacings, turned about z by 90 degrees.
  const std::array<int, 3> size{16, 10, 8};
  std::vector<std::uint8_t> labels;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) labels.push_back(i < 8 ? 1 : 2);
    }
  }
  const Pose X_WL{glm::angleAxis(glm::radians(90.0), Vec3(0, 0, 1)), {10, 20, 30}};
  const LabelMap map{.size = size, .spacing_mm = {0.41, 0.6, 0.8}, .X_WL = X_WL, .labels = labels};
  const Bone bone = MakeBoneFromLabels(map, {{1, 24}, {2, 32}}, 0.2);
  EXPECT_EQ(bone.RegionAt(X_WL.Point({1, 2, 2})), 24);
  EXPECT_EQ(bone.RegionAt(X_WL.Point({5, 2, 2})), 32);
  // A tooth that touches the surface from outside finds a material.
  EXPECT_EQ(bone.RegionAt(X_WL.Point({-0.35, 2, 2})), 24);
  const auto mm3 = bone.CalcRegionVolumes();
  // The border of 6 x 6.4 mm2 is off by up to half a region voxel of 0.2 mm, which one half gains and the other loses.
  EXPECT_NEAR(mm3.at(24), mm3.at(32), 2 * 0.1 * 6 * 6.4);
  EXPECT_NEAR(bone.SignedDistance(X_WL.Point({-0.2, 2.4, 2.8})), 0, 0.02);  // a tenth of a voxel

  // Only the first label: half of the bone.
  EXPECT_NEAR(MakeBoneFromLabels(map, {{1, 24}}, 0.2).CalcVolume(), 0.5 * bone.CalcVolume(),
              0.02 * bone.CalcVolume());  // its edges
}

TEST(LabelMap, InvalidOnesAreRefused) {
  const std::vector<std::uint8_t> labels(8, 1);
  LabelMap map{.size = {2, 2, 2}, .spacing_mm = Vec3(1), .X_WL = {}, .labels = labels};
  EXPECT_THAT(MessageOf([&] { MakeBoneFromLabels(map, {{2, 24}}, 0.2); }), HasSubstr("no voxel"));
  EXPECT_THAT(MessageOf([&] { MakeBoneFromLabels(map, {}, 0.2); }), HasSubstr("no label"));
  EXPECT_THAT(MessageOf([&] { MakeBoneFromLabels(map, {{1, 99}}, 0.2); }), HasSubstr("99"));
  EXPECT_THAT(MessageOf([&] { MakeBoneFromLabels(map, {{300, 24}}, 0.2); }), HasSubstr("300"));
  map.size = {2, 2, 3};
  EXPECT_THAT(MessageOf([&] { MakeBoneFromLabels(map, {{1, 24}}, 0.2); }), HasSubstr("12 labels, not 8"));
  map.size = {2, 2, 2};
  map.spacing_mm.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(MessageOf([&] { MakeBoneFromLabels(map, {{1, 24}}, 0.2); }), HasSubstr("spacing_mm"));
}

TEST(BoneLeaves, AreTheBonesOwnMemoryAndLieWhereTheySay) {
  BlockParams block;
  block.size_mm = {4, 3, 2};
  block.voxel_mm = 0.2;
  const Bone bone = MakeBlock(block);
  const std::vector<BoneLeaf> leaves = ListLeaves(bone), again = ListLeaves(bone);
  ASSERT_FALSE(leaves.empty());
  ASSERT_EQ(leaves.size(), again.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) EXPECT_EQ(leaves[i].phi_mm.data(), again[i].phi_mm.data());
  for (const BoneLeaf& leaf : leaves) {
    const Vec3 p_W = 0.2 * Vec3(leaf.first_voxel[0] + 1, leaf.first_voxel[1] + 2, leaf.first_voxel[2] + 3);
    EXPECT_NEAR(bone.SignedDistance(p_W), static_cast<double>(leaf.phi_mm[64 * 1 + 8 * 2 + 3]), 1e-6);
  }
}

TEST(ImportBone, OfASurfaceHasItsVolumeAndCanBeCancelled) {
  const test::Folder folder;
  BlockParams block;
  block.size_mm = {12, 8, 6};
  block.voxel_mm = 0.2;
  const TriangleMesh mesh = ExtractSurface(MakeBlock(block));
  std::string obj;
  for (const Vec3& p : mesh.points)
    obj += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  for (const auto& t : mesh.triangles) {
    obj += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
  }
  test::WriteBytes(folder.file("block.obj"), obj);
  ImportSettings settings;
  settings.voxel_mm = 0.2;
  settings.mesh_units = "mm";
  const ImportedBone imported = ImportBone(folder.file("block.obj"), settings);
  EXPECT_NEAR(imported.bone.CalcVolume(), 12 * 8 * 6, 0.01 * 12 * 8 * 6);
  settings.progress = [](double) { return false; };
  EXPECT_THAT(MessageOf([&] { ImportBone(folder.file("block.obj"), settings); }), HasSubstr("cancelled"));
  settings.voxel_mm = 5;
  EXPECT_THAT(MessageOf([&] { ImportBone(folder.file("block.obj"), settings); }), HasSubstr("voxel_mm"));
}

// ---- scenes and runs

TEST(SceneFile, ValuesAreSetWithTheErrorsOfTheProgram) {
  const SceneFile scene = SceneFile::Parse(kScene, "block.toml");
  EXPECT_EQ(scene.name(), "block");
  EXPECT_EQ(scene.With("tool", "rpm", "3000").rpm(), 3000);
  EXPECT_EQ(scene.rpm(), 7500);
  EXPECT_EQ(std::get<DiscSaw>(scene.With("tool", "diameter_mm", "12").tool()).diameter_mm, 12);
  EXPECT_THAT(MessageOf([&] { scene.With("tool", "thickness_mm", "-1"); }), HasSubstr("block.toml:"));
  EXPECT_THAT(MessageOf([&] { scene.With("tool", "thicknes_mm", "1"); }), HasSubstr("thickness_mm"));
  EXPECT_EQ(MessageOf([&] { scene.With("tool", "shape", "disc"); }),
            "the value of tool.shape is not valid TOML: disc (a text needs quotes)");
  EXPECT_EQ(SceneFile::Parse(scene.Resolve()).Resolve(), scene.Resolve());
}

TEST(Runs, TickByTickOrAtOnceGiveTheSameBits) {
  const SceneFile scene = SceneFile::Parse(kScene);
  const PathRun run = RunAlongPath(scene);
  const std::vector<PathStep> steps = scene.ListPathSteps();
  ASSERT_TRUE(steps.front().set_down);
  Simulation simulation(scene.MakeBone(), scene.MakeSimulationParams(), steps.front().X_WT);
  std::size_t ticks = 0;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const TickOutput out = simulation.Tick({.X_WT = steps[i].X_WT, .dt_s = steps[i].dt_s, .rpm = scene.rpm()});
    EXPECT_EQ(out.f_T_W_N, run.ticks[ticks].out.f_T_W_N);
    ++ticks;
  }
  EXPECT_EQ(ticks, run.ticks.size());
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), run.bone.CalcHash());
  // The centre ends in the middle of the block: half of the slot and the disc's front in it.
  EXPECT_GT(run.removed_mm3, 0.5 * 2 * 6);
  double sum_mm3 = 0;
  for (const double mm3 : run.removed_mm3_by_region) sum_mm3 += mm3;
  EXPECT_EQ(sum_mm3, run.removed_mm3);
}

TEST(TickWarnings, OfTicksOnesOwnAreThoseOfTheRun) {
  // 20 mm/s are too fast for the law, and 0.25 mm are too thin for the voxels.
  const SceneFile scene =
      SceneFile::Parse(kScene).With("tool", "thickness_mm", "0.25").With("force", "law", "\"hertz_chip\"");
  const std::vector<PathStep> steps = scene.ListPathSteps();
  const Bone bone = scene.MakeBone();
  Simulation simulation(bone, scene.MakeSimulationParams(), steps.front().X_WT);
  TickWarnings warnings(scene.MakeSimulationParams(), bone, steps.front().X_WT, simulation.ListChannels());
  EXPECT_THAT(warnings.Find(0), ::testing::ElementsAre(HasSubstr("1.25 voxels thick")));
  std::vector<double> channels(simulation.ListChannels().size());
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const TickInput in{.X_WT = steps[i].X_WT, .dt_s = steps[i].dt_s, .rpm = scene.rpm()};
    const TickOutput out = simulation.Tick(in);
    simulation.ReadChannels(channels);
    warnings.Add(in, out, channels);
  }
  double removed_mm3 = 0;
  for (const double mm3 : simulation.CalcRemovedByRegion()) removed_mm3 += mm3;
  EXPECT_THAT(warnings.Find(removed_mm3), ::testing::Contains(HasSubstr("the bite reaches 6.67 um")));
  EXPECT_EQ(warnings.Find(removed_mm3), RunAlongPath(scene).warnings);
}

TEST(Runs, AreCancelledByTheirProgress) {
  const PathRunOptions options{.record = "", .progress = [](double fraction) { return fraction < 0.7; }};
  EXPECT_THAT(MessageOf([&] { RunAlongPath(SceneFile::Parse(kScene), options); }), HasSubstr("cancelled"));
}

TEST(Runs, SlabModeIsRunIfTheSceneSaysSo) {
  const SceneFile scene =
      SceneFile::Parse(std::string(kScene) + "\n[simulation]\nmode = \"slab\"\n\n[slab]\ndirection = [1, 0, 0]\n");
  const PathRun run = RunAlongPath(scene);
  EXPECT_EQ(run.slab_states.size(), run.ticks.size());
  EXPECT_EQ(run.removed_mm3, 0);
  EXPECT_GT(run.slab_states.back().deepest_mm, 0);
}

TEST(Recordings, OfAPathGiveItsInputsAndReplayToTheSameBits) {
  const test::Folder folder;
  const SceneFile scene = SceneFile::Parse(kScene);
  const std::string file = folder.file("a.kerf");
  const PathRun run = RunAlongPath(scene, {.record = file, .progress = {}});
  Recording recording(file);
  EXPECT_EQ(recording.kind(), "run");
  EXPECT_EQ(recording.damage(), "");
  EXPECT_EQ(recording.scene().rpm(), scene.rpm());
  const std::vector<RecordedInput> inputs = recording.ReadInputs();
  const std::vector<PathStep> steps = scene.ListPathSteps();
  ASSERT_EQ(inputs.size(), steps.size());
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    EXPECT_EQ(inputs[i].X.p_AB, steps[i].X_WT.p_AB);
    EXPECT_EQ(inputs[i].set_down, steps[i].set_down);
    EXPECT_NEAR(inputs[i].time_s, steps[i].time_s, 1e-9);  // sums of the ticks' durations
  }
  const PathRun again = recording.ReplayPath();
  EXPECT_FALSE(again.difference);
  EXPECT_EQ(again.bone.CalcHash(), run.bone.CalcHash());
  EXPECT_THAT(MessageOf([&] { recording.ReplayHand(); }), HasSubstr("along a path"));
  EXPECT_THAT(MessageOf([&] { RunAlongPath(scene, {.record = file, .progress = {}}); }), HasSubstr("a.kerf"));
}

/// Handle that is led down by 3 mm in half a second.
class LedHandle final : public Device {
 public:
  explicit LedHandle(const Pose& X) : X_(X) {}
  const DeviceProfile& profile() const override { return profile_; }
  void Elapse(double dt_s) noexcept override { X_.p_AB.z -= 6 * dt_s; }
  bool Read(DeviceSample& sample) noexcept override {
    sample.X_WH = X_;
    return true;
  }
  bool Write(const Vec3& f_H_W_N, const Vec3&) noexcept override {
    ++writes;
    peak_N = std::max(peak_N, glm::length(f_H_W_N));
    return true;
  }
  int writes = 0;
  double peak_N = 0;

 private:
  DeviceProfile profile_;
  Pose X_;
};

TEST(Runs, InAHandAreMovedByAnOwnDeviceRecordedAndReplayed) {
  const test::Folder folder;
  SceneFile scene = SceneFile::Parse(kScene);
  scene = scene.With("device", "profile", "\"omega_6\"");
  LedHandle handle({glm::angleAxis(glm::radians(-90.0), Vec3(1, 0, 0)), {-3, 0, 6}});
  HandRunOptions options;
  options.seconds = 0.5;
  options.device = &handle;
  options.record = folder.file("hand.kerf");
  const HandRun run = RunInHand(scene, options);
  EXPECT_EQ(run.ticks.size(), 500u);
  EXPECT_GE(handle.writes, 500);
  EXPECT_GT(run.removed_mm3, 0.1);
  EXPECT_NEAR(run.removed_mm3, scene.MakeBone().CalcVolume() - run.bone.CalcVolume(), 1e-6 * 432);  // of the volume
  double peak_N = 0;
  for (const HandTick& tick : run.ticks) peak_N = std::max(peak_N, glm::length(tick.f_device_N));
  EXPECT_EQ(peak_N, handle.peak_N);
  Recording recording(options.record);
  EXPECT_EQ(recording.kind(), "loop");
  const HandRun again = recording.ReplayHand();
  EXPECT_FALSE(again.difference);
  EXPECT_EQ(again.bone.CalcHash(), run.bone.CalcHash());

  const std::atomic<bool> stop = true;
  options.stop = &stop;
  options.record.clear();
  EXPECT_LT(RunInHand(scene, options).ticks.size(), 500u);
  options.seconds = -1;
  EXPECT_THAT(MessageOf([&] { RunInHand(scene, options); }), HasSubstr("seconds"));
}

// ---- the sense in which a tool turns

/// A block with its top at z = 0 and a tool above it, which has its handpiece at the top.
SceneFile MakeScene(const std::string& tool, const Vec3& size_mm, const Vec3& from_mm, const Vec3& to_mm,
                    double feed_mm_per_s) {
  return SceneFile::Parse(fmt::format(
      "[bone]\nmodel = \"block\"\n[bone.block]\nsize_x_mm = {}\nsize_y_mm = {}\nsize_z_mm = {}\nvoxel_mm = 0.1\n"
      "[tool]\n{}\n[[path.stroke]]\nstart_mm = [{}, {}, {}]\nend_mm = [{}, {}, {}]\nfeed_mm_per_s = {}\n"
      "disc_normal = [0, 0, 1]\n[force]\nlaw = \"hertz_chip\"\n",
      size_mm.x, size_mm.y, size_mm.z, tool, from_mm.x, from_mm.y, from_mm.z, to_mm.x, to_mm.y, to_mm.z,
      feed_mm_per_s));
}

SceneFile WithTangentialForce(const SceneFile& scene, double ratio) {
  return scene.With("effects.tangential_force", "ratio", std::to_string(ratio));
}

const char* const kDrill = "shape = \"drill\"\ndiameter_mm = 2\nrpm = 1000\nchisel_share = 0";
const char* const kBur = "shape = \"bur\"\ndiameter_mm = 2\nrpm = 30000";

// The thrust of the lips is spread evenly along them, so that the mean distance of their cutting force from the axis is
// half the radius. A drill turns clockwise as seen from its handpiece; the bone turns it the other way: about +z.
TEST(SenseOfRotation, ReactionTorqueOpposesAClockwiseDrill) {
  const SceneFile drill = MakeScene(kDrill, {6, 6, 4}, {0, 0, 0.5}, {0, 0, -2}, 2);
  EXPECT_EQ(drill.rpm(), -1000);
  const double thrust_sum_N = RunAlongPath(drill).ticks.back().out.thrust_sum_N;
  const double torque_Nmm = thrust_sum_N / 1.6 * 0.5 * 1;
  ASSERT_GT(torque_Nmm, 1);
  const SceneFile loaded = WithTangentialForce(drill, 1.6);
  const double clockwise_Nmm = RunAlongPath(loaded).ticks.back().out.tau_TG_W_Nmm.z;
  EXPECT_NEAR(clockwise_Nmm, torque_Nmm,
              0.05 * torque_Nmm);  // the bone begins at the lips within a fraction of a voxel
  const SceneFile reversed = loaded.With("tool", "reverse", "true");
  EXPECT_EQ(reversed.rpm(), 1000);
  EXPECT_NEAR(RunAlongPath(reversed).ticks.back().out.tau_TG_W_Nmm.z, -clockwise_Nmm, 1e-9 * torque_Nmm);
}

// A bur that is fed along +x, with its handpiece above, cuts with the half towards its wall. On the side of +y, its
// flutes move along +x, with the feed: a conventional cut, which holds it back. On the other side they move along -x: a
// climb cut, which pulls it on. The cutting force is the thrust, turned by a quarter and divided by the ratio.
TEST(SenseOfRotation, BurIsHeldBackByAWallOnItsLeftAndPulledOnByOneOnItsRight) {
  constexpr double kRatio = 1.6;
  PathRun left, reversed_right;
  for (const double side : {1.0, -1.0}) {
    // The tip is below the block, so that only the side cuts.
    const SceneFile bur = MakeScene(kBur, {8, 6, 2}, {-6, -3 * side, -4}, {0, -3 * side, -4}, 5);
    const PathRun alone = RunAlongPath(bur), loaded = RunAlongPath(WithTangentialForce(bur, kRatio));
    const std::size_t last = alone.ticks.size() - 1;
    const Vec3 f_N = loaded.ticks[last].out.f_T_W_N - alone.ticks[last].out.f_T_W_N;
    const Vec3 thrust_N = alone.ticks[last - 1].out.f_T_W_N;  // on a path the force is that of the step before
    ASSERT_LT(side * thrust_N.y, -0.1);
    EXPECT_LT(glm::length(f_N - Vec3(thrust_N.y, -thrust_N.x, 0) / kRatio), 1e-6 * glm::length(f_N));
    EXPECT_LT(side * f_N.x, 0);
    if (side > 0) left = loaded;
    if (side < 0) reversed_right = RunAlongPath(WithTangentialForce(bur, kRatio).With("tool", "reverse", "true"));
  }
  // The mirror image of a cut in y = 0 turns the other way.
  double largest_N = 0, off_N = 0;
  for (std::size_t i = 0; i < left.ticks.size(); ++i) {
    const Vec3 f_N = left.ticks[i].out.f_T_W_N, image_N = reversed_right.ticks[i].out.f_T_W_N;
    largest_N = std::max(largest_N, glm::length(f_N));
    off_N = std::max(off_N, glm::length(f_N - image_N * Vec3(1, -1, 1)));
  }
  EXPECT_LT(off_N, 1e-4 * largest_N);  // the level set is stored as floats, which are rounded differently
}

TEST(SenseOfRotation, IsRecordedAndNotAppliedAgainByAReplay) {
  const test::Folder folder;
  for (const char* reverse : {"false", "true"}) {
    const SceneFile scene = WithTangentialForce(MakeScene(kDrill, {6, 6, 4}, {0, 0, 0.5}, {0, 0, -2}, 2), 1.6)
                                .With("hand", "push_N", "40")
                                .With("tool", "reverse", reverse);
    HandRunOptions options;
    options.seconds = 2;
    options.record = folder.file(fmt::format("hand_{}.kerf", reverse));
    const HandRun run = RunInHand(scene, options);
    const PathRun path =
        RunAlongPath(scene, {.record = folder.file(fmt::format("path_{}.kerf", reverse)), .progress = {}});
    Recording hand(options.record), along(folder.file(fmt::format("path_{}.kerf", reverse)));
    EXPECT_EQ(along.ReadInputs().back().rpm, scene.rpm());
    EXPECT_FALSE(along.ReplayPath().difference);
    const HandRun again = hand.ReplayHand();
    EXPECT_FALSE(again.difference);
    EXPECT_GT(run.removed_mm3, 0.001);
    for (const HandTick& tick : again.ticks) ASSERT_EQ(tick.rpm, scene.rpm());
  }
  // A recording made when drills turned about +z states that in its ticks, whatever its scene means today.
  test::ForgeRecording(folder.file("hand_true.kerf"), folder.file("old.kerf"), [](BlockKind kind, std::string& bytes) {
    if (kind != BlockKind::kMeta) return;
    const std::size_t at = bytes.find("reverse = true");
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at, 14, "reverse =false");
  });
  Recording old(folder.file("old.kerf"));
  EXPECT_EQ(old.scene().rpm(), -1000);
  const HandRun again = old.ReplayHand();
  EXPECT_FALSE(again.difference);
  EXPECT_EQ(again.ticks.back().rpm, 1000);
}

TEST(Checkpoints, UndoAndRedoRestoreEachBit) {
  const SceneFile scene = SceneFile::Parse(kScene);
  const Quat upright = glm::angleAxis(glm::radians(-90.0), Vec3(1, 0, 0));
  CoupledSimulation simulation(scene.MakeBone(), scene.MakeCoupledParams(), {upright, {0, 0, 6}});
  Checkpoints checkpoints(simulation);
  const auto cut_to = [&](double from_mm, double to_mm) {
    for (int i = 1; i <= 200; ++i) {
      simulation.Tick({.X_WH = {upright, {0, 0, from_mm + (to_mm - from_mm) * i / 200}}});
      checkpoints.Update();
    }
    return simulation.UpdateBone().CalcHash();
  };
  const std::uint64_t whole = simulation.UpdateBone().CalcHash();
  const std::uint64_t first = cut_to(6, 4);
  checkpoints.Make("first");
  const std::uint64_t second = cut_to(4, 3);
  ASSERT_NE(first, whole);
  ASSERT_NE(second, first);
  checkpoints.Undo();
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), first);
  EXPECT_TRUE(checkpoints.CanRedo());
  checkpoints.Redo();
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), second);
  checkpoints.Undo("start");
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), whole);
  EXPECT_THAT(MessageOf([&] { checkpoints.Undo("nowhere"); }), HasSubstr("nowhere"));
}

// ---- what a program adds

ForceLawInfo MakeLawInfo(const char* name, ToothForce::Function thrust) {
  static ToothForce::Function made;
  made = thrust;
  return {.name = name,
          .summary = "a law of a test",
          .source = "a test",
          .validity = {},
          .parameters = {},
          .make = [](const LawValues&, const Tooth&, const std::shared_ptr<const ForceTable>&) {
            ToothForce force;
            force.thrust = made;
            return force;
          }};
}

TEST(OwnForceLaw, IsUsedLikeKerfsOwn) {
  RegisterForceLaw(MakeLawInfo("test_linear", [](const ToothForce&, double bite_mm, const ToothCut& cut) {
    return cut.E_MPa > 0 ? 100 * bite_mm : 0.0;
  }));
  const PathRun run = RunAlongPath(SceneFile::Parse(kScene).With("force", "law", "\"test_linear\""));
  int engaged = 0;
  for (const TickRecord& tick : run.ticks) {
    // The sum over the teeth of a linear law is the number of teeth times the mean bite.
    if (tick.out.engaged_teeth <= 0) continue;
    ++engaged;
    EXPECT_NEAR(tick.out.thrust_sum_N, 100 * tick.out.engaged_teeth * tick.out.mean_bite_mm, 1e-9);
  }
  EXPECT_GT(engaged, 100);
}

TEST(OwnForceLaw, ThatBreaksARuleIsRefused) {
  const auto refusal = [](ToothForce::Function thrust) {
    return MessageOf([&] { RegisterForceLaw(MakeLawInfo("test_bad", thrust)); });
  };
  EXPECT_THAT(refusal([](const ToothForce&, double bite_mm, const ToothCut& cut) {
                return cut.E_MPa > 0 ? 1 / (1 + bite_mm) : 0;
              }),
              HasSubstr("its thrust falls"));
  EXPECT_THAT(refusal([](const ToothForce&, double bite_mm, const ToothCut&) { return bite_mm; }),
              HasSubstr("no material"));
  EXPECT_THAT(refusal([](const ToothForce&, double bite_mm, const ToothCut& cut) {
                return cut.E_MPa * std::log(bite_mm - 100);
              }),
              HasSubstr("finite"));
  EXPECT_THAT(refusal(nullptr), HasSubstr("no thrust"));
  const auto refusal_of_key = [](std::vector<LawParameter> parameters) {
    ForceLawInfo info = MakeLawInfo(
        "test_bad", [](const ToothForce&, double bite_mm, const ToothCut& cut) { return cut.E_MPa * bite_mm; });
    info.parameters = std::move(parameters);
    return MessageOf([&] { RegisterForceLaw(info); });
  };
  EXPECT_THAT(refusal_of_key({{"Bad key", 1, 0, 2, ""}}), HasSubstr("\"Bad key\""));
  EXPECT_THAT(refusal_of_key({{"law", 1, 0, 2, ""}}), HasSubstr("the name law"));
  EXPECT_THAT(refusal_of_key({{"a", 1, 0, 2, ""}, {"a", 1, 0, 2, ""}}), HasSubstr("two parameters a"));
  EXPECT_THAT(refusal([](const ToothForce&, double bite_mm, const ToothCut& cut) {
                static double last = 0;
                return cut.E_MPa > 0 ? bite_mm + 1e-9 * ++last : 0;
              }),
              HasSubstr("two different forces"));
  const auto zero = [](const ToothForce&, double, const ToothCut&) { return 0.0; };
  EXPECT_THAT(MessageOf([&] { RegisterForceLaw(MakeLawInfo("hertz_chip", zero)); }), HasSubstr("already"));
  EXPECT_THAT(MessageOf([&] { RegisterForceLaw(MakeLawInfo("Test law", zero)); }), HasSubstr("lower-case"));
  EXPECT_THAT(MessageOf([&] { ForceLaw("test_bad"); }), HasSubstr("test_bad"));
}

/// Law and effect that keep the rules until they are set to break one.
struct LateFault {
  int calls_until = std::numeric_limits<int>::max();  // of the law
  double force_N = std::numeric_limits<double>::quiet_NaN();
  enum { kGives, kThrows, kThrowsNumber } does = kGives;

  double Break() const {
    if (does == kThrows) throw std::runtime_error("the table ends here");
    if (does == kThrowsNumber) throw 3;
    return force_N;
  }
};
LateFault late;

SceneFile MakeLateScene() {
  late = {};
  static const bool registered [[maybe_unused]] = [] {
    ForceLawInfo info = MakeLawInfo("test_late", nullptr);
    info.make = [](const LawValues&, const Tooth&, const std::shared_ptr<const ForceTable>&) {
      ToothForce force;
      force.thrust = [](const ToothForce&, double bite_mm, const ToothCut& cut) {
        if (cut.E_MPa <= 0) return 0.0;
        return --late.calls_until < 0 ? late.Break() : 1000 * bite_mm;
      };
      return force;
    };
    RegisterForceLaw(info);
    return true;
  }();
  return SceneFile::Parse(kScene).With("force", "law", "\"test_late\"");
}

/// The faults that a law can have in a tick, with what is said about them.
std::vector<std::pair<LateFault, std::string>> ListLateFaults() {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  return {{{.calls_until = 0}, "test_late gives a thrust of nan N at a bite of "},
          {{.calls_until = 0, .force_N = kInfinite}, "test_late gives a thrust of inf N at a bite of "},
          {{.calls_until = 0, .force_N = -2}, "test_late gives a thrust of -2 N at a bite of "},
          {{.calls_until = 0, .does = LateFault::kThrows}, "test_late threw an exception: the table ends here"},
          {{.calls_until = 0, .does = LateFault::kThrowsNumber}, "test_late threw an exception"}};
}

TEST(OwnForceLaw, ThatBreaksARuleInATickOnAPathLeavesTheStateBeforeTheTick) {
  const SceneFile scene = MakeLateScene();
  const std::vector<PathStep> steps = scene.ListPathSteps();
  Simulation simulation(scene.MakeBone(), scene.MakeSimulationParams(), steps.front().X_WT);
  Simulation undisturbed(scene.MakeBone(), scene.MakeSimulationParams(), steps.front().X_WT);
  const auto faults = ListLateFaults();
  std::size_t seen = 0, calls = 0;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const TickInput in{.X_WT = steps[i].X_WT, .dt_s = steps[i].dt_s, .rpm = scene.rpm()};
    ++calls;
    if (i > 400 && i % 20 == 0 && seen < faults.size()) {
      const std::uint64_t before = simulation.UpdateBone().CalcHash();
      late = faults[seen].first;
      const std::string message = MessageOf([&] { simulation.Tick(in); });
      late = {};
      EXPECT_THAT(message, HasSubstr("tick " + std::to_string(calls) + ": the force law " + faults[seen].second));
      EXPECT_EQ(simulation.UpdateBone().CalcHash(), before);
      ++seen;
      ++calls;
    }
    const TickOutput out = simulation.Tick(in), other = undisturbed.Tick(in);
    ASSERT_EQ(out.f_T_W_N, other.f_T_W_N) << i;
    ASSERT_EQ(out.removed_mm3, other.removed_mm3) << i;
  }
  EXPECT_EQ(seen, faults.size());
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), undisturbed.UpdateBone().CalcHash());
}

TEST(OwnForceLaw, ThatBreaksARuleInATickInAHandLeavesTheToolWhereItWas) {
  const SceneFile scene = MakeLateScene();
  const Quat upright = glm::angleAxis(glm::radians(-90.0), Vec3(1, 0, 0));
  for (const auto& [fault, words] : ListLateFaults()) {
    CoupledSimulation simulation(scene.MakeBone(), scene.MakeCoupledParams(), {upright, {0, 0, 6}});
    const auto handle = [&](int tick) { return CoupledInput{.X_WH = {upright, {0, 0, 6 - 0.01 * tick}}}; };
    Pose X_WT;
    for (int i = 1; i <= 300; ++i) X_WT = simulation.Tick(handle(i)).X_WT;
    const std::uint64_t before = simulation.UpdateBone().CalcHash();
    late = fault;
    EXPECT_THAT(MessageOf([&] { simulation.Tick(handle(301)); }), HasSubstr("tick 301: the force law " + words));
    late = {};
    EXPECT_EQ(simulation.UpdateBone().CalcHash(), before);
    // It stands where it was, and can go on.
    const CoupledOutput out = simulation.Tick(handle(301));
    EXPECT_LT(glm::length(out.X_WT.p_AB - X_WT.p_AB), 0.1);  // a tick moves the handle by 0.01 mm
    EXPECT_GT(out.thrust_sum_N, 0);
    EXPECT_TRUE(std::isfinite(glm::length(out.f_H_W_N)));
  }
}

TEST(OwnForceLaw, ThatBreaksARuleInATickEndsEachRunWithAnError) {
  const test::Folder folder;
  const SceneFile scene = MakeLateScene();
  HandRunOptions virtual_time, real_time;
  virtual_time.seconds = 2;
  real_time.seconds = 60;
  real_time.real_time = true;
  for (auto [fault, words] : ListLateFaults()) {
    fault.calls_until = 2000;
    late = fault;
    std::filesystem::remove(folder.file("late.kerf"));
    const std::string message =
        MessageOf([&] { RunAlongPath(scene, {.record = folder.file("late.kerf"), .progress = {}}); });
    EXPECT_THAT(message, HasSubstr(": the force law " + words));
    // The recording keeps every tick before it, and that the tool was set down at the start of the path.
    const Recording recording(folder.file("late.kerf"));
    EXPECT_EQ(recording.damage(), "");
    EXPECT_THAT(message, HasSubstr("tick " + std::to_string(recording.ticks()) + ":"));
    late = fault;
    EXPECT_THAT(MessageOf([&] { RunInHand(scene, virtual_time); }), HasSubstr(": the force law " + words));
    if (fault.does == LateFault::kGives && !std::isnan(fault.force_N)) continue;  // real time takes long enough
    late = fault;
    EXPECT_THAT(MessageOf([&] { RunInHand(scene, real_time); }), HasSubstr(": the force law " + words));
  }
  late = {};
}

/// Keeps the rules for 100 ticks.
class LateEffect final : public OwnEffect {
 public:
  explicit LateEffect(double does) : does_(does) {}
  void Begin(EffectBegin& begin) override {
    if (++ticks_ <= 100) return;
    if (does_ == 1) begin.rpm = std::numeric_limits<double>::quiet_NaN();
    if (does_ == 2) throw std::runtime_error("no speed");
  }
  void Solved(const OwnEffectStep&) override {
    if (ticks_ > 100 && does_ == 3) throw std::runtime_error("no teeth");
  }
  void End(OwnEffectEnd& end) override {
    if (ticks_ <= 100) return;
    if (does_ == 4) end.f_extra_W_N.y = std::numeric_limits<double>::infinity();
    if (does_ == 5) throw 5;
  }

 private:
  double does_;
  int ticks_ = 0;
};

TEST(OwnEffect, ThatBreaksARuleInATickEndsEachRunWithAnError) {
  EffectInfo info{.name = "test_late_effect",
                  .summary = "a test",
                  .source = "a test",
                  .reads = "teeth",
                  .writes = "force",
                  .state = "none",
                  .sleeps = "never"};
  info.hooks = kEffectBegin | kEffectSolved | kEffectEnd | kEffectPush;
  info.parameters = {{"does", 0.0, 0, 5, "what it does"}};
  info.make_own = [](std::span<const EffectValue> values, const OwnEffectSetup&) {
    return std::unique_ptr<OwnEffect>(new LateEffect(std::get<double>(values[0])));
  };
  RegisterEffect(info);
  const std::vector<std::string> words{"sets a speed of nan rpm", "threw an exception: no speed",
                                       "threw an exception: no teeth", "pushes the hand with a force of (0, inf, 0) N",
                                       "threw an exception"};
  HandRunOptions in_hand;
  in_hand.seconds = 2;
  for (std::size_t i = 0; i < words.size(); ++i) {
    // Begin() and End() are called in each tick, Solved() only while bone is near.
    const std::string tick = i == 2 ? "" : "tick 101: ";
    const std::string expected = tick + "the effect test_late_effect " + words[i];
    const SceneFile scene = SceneFile::Parse(kScene).With("effects.test_late_effect", "does", std::to_string(i + 1));
    EXPECT_THAT(MessageOf([&] { RunAlongPath(scene); }), HasSubstr(expected));
    EXPECT_THAT(MessageOf([&] { RunInHand(scene, in_hand); }), HasSubstr(expected));
    const Pose start = scene.ListPathSteps().front().X_WT;
    CoupledSimulation simulation(scene.MakeBone(), scene.MakeCoupledParams(), start);
    EXPECT_THAT(MessageOf([&] {
                  for (int k = 0; k < 2000; ++k) {
                    simulation.Tick({.X_WH = {start.R_AB, start.p_AB + Vec3(0.01 * k, 0, 0)}});
                  }
                }),
                HasSubstr(expected));
  }
}

/// Reports what it is given, halves the speed of the spindle, and pushes the hand.
class TestEffect final : public OwnEffect {
 public:
  explicit TestEffect(double push_N) : push_N_(push_N) {}
  void Begin(EffectBegin& begin) noexcept override { begin.rpm = 0.5 * begin.set_rpm; }
  void Solved(const OwnEffectStep& step) noexcept override {
    for (const ToothLoad& load : step.teeth) thrust_Ns_ += load.thrust_N * step.time_s;
    X_WT_ = step.X_WT_to;
  }
  void End(OwnEffectEnd& end) noexcept override {
    rpm_ = end.rpm;
    end.f_extra_W_N = {0, 0, push_N_};
  }
  void Report(std::span<double> channels) const noexcept override {
    channels[0] = thrust_Ns_;
    channels[1] = rpm_;
    channels[2] = X_WT_.p_AB.x;
  }

 private:
  double push_N_;
  double thrust_Ns_ = 0, rpm_ = 0;
  Pose X_WT_;
};

TEST(OwnEffect, SeesTheTeethSetsTheSpeedAndPushesTheHand) {
  EffectInfo info{.name = "test_effect",
                  .summary = "a test",
                  .source = "a test",
                  .reads = "teeth",
                  .writes = "force",
                  .state = "impulse",
                  .sleeps = "never"};
  info.hooks = kEffectBegin | kEffectSolved | kEffectEnd | kEffectPush;
  info.parameters = {{"push_N", 0.0, -5, 5, "force on the hand"}};
  info.channels = {{"thrust_Ns", "impulse of the teeth"}, {"rpm", "speed"}, {"x_mm", "place"}};
  info.make_own = [](std::span<const EffectValue> values, const OwnEffectSetup& setup) {
    EXPECT_GT(setup.bone.CalcVolume(), 0);
    return std::unique_ptr<OwnEffect>(new TestEffect(std::get<double>(values[0])));
  };
  RegisterEffect(info);
  EXPECT_THAT(MessageOf([&] { RegisterEffect(info); }), HasSubstr("already"));

  const SceneFile scene = SceneFile::Parse(kScene).With("effects.test_effect", "push_N", "2");
  const PathRun run = RunAlongPath(scene);
  EXPECT_EQ(run.channels.names,
            (std::vector<std::string>{"test_effect.thrust_Ns", "test_effect.rpm", "test_effect.x_mm"}));
  ASSERT_EQ(run.channels.rows(), run.ticks.size());
  double thrust_Ns = 0;
  double last_s = 0;
  for (const TickRecord& tick : run.ticks) {
    thrust_Ns += tick.out.thrust_sum_N * (tick.time_s - last_s);
    last_s = tick.time_s;
  }
  const double* last = &run.channels.values[3 * (run.channels.rows() - 1)];
  EXPECT_NEAR(last[0], thrust_Ns, 1e-9 * thrust_Ns);
  EXPECT_GT(thrust_Ns, 0);
  EXPECT_EQ(last[1], 3750);
  EXPECT_NEAR(last[2], 0, 1e-9);  // the end of the stroke, in the world frame

  // In air the force on the hand is that of the effect alone.
  CoupledSimulation simulation(scene.MakeBone(), scene.MakeCoupledParams(), {{1, 0, 0, 0}, {0, 0, 60}});
  EXPECT_EQ(simulation.Tick({.X_WH = {{1, 0, 0, 0}, {0, 0, 60}}}).f_H_W_N, Vec3(0, 0, 2));
  EXPECT_EQ(simulation.ListChannels(), run.channels.names);
  std::array<double, 3> values{};
  simulation.ReadChannels(values);
  EXPECT_EQ(values[1], 3750);

  // Without kEffectPush it does not.
  info.name = "test_without_push";
  info.hooks = kEffectBegin | kEffectSolved | kEffectEnd;
  RegisterEffect(info);
  const SceneFile without = SceneFile::Parse(kScene).With("effects.test_without_push", "push_N", "2");
  CoupledSimulation unpushed(without.MakeBone(), without.MakeCoupledParams(), {{1, 0, 0, 0}, {0, 0, 60}});
  EXPECT_EQ(unpushed.Tick({.X_WH = {{1, 0, 0, 0}, {0, 0, 60}}}).f_H_W_N, Vec3(0));

  info.name = "test_other";
  info.hooks = kEffectEngage;
  EXPECT_THAT(MessageOf([&] { RegisterEffect(info); }), HasSubstr("hook"));
  info.hooks = kEffectEnd;
  info.make_own = nullptr;
  EXPECT_THAT(MessageOf([&] { RegisterEffect(info); }), HasSubstr("make_own"));
}

TEST(Version, OfHeadersAndLibraryAreTheSame) {
  EXPECT_EQ(VersionString(), std::to_string(KERF_VERSION_MAJOR) + "." + std::to_string(KERF_VERSION_MINOR) + "." +
                                 std::to_string(KERF_VERSION_PATCH));
}

}  // namespace
}  // namespace kerf
