#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <glm/geometric.hpp>

#include "base/files/files.h"
#include "experiment/study/case.h"
#include "experiment/study/case_run.h"
#include "experiment/study/reference_store.h"
#include "kerf/error.h"
#include "support/block_scene.h"
#include "support/folder.h"

namespace kerf {
namespace {

constexpr double kTolerance = 2e-3;

/// Returns only a section of a built-in path, because references take long.
StudyPath MakeStretch(const std::string& name, double from_s, double to_s) {
  StudyPath path = MakeStudyPaths({name}, "").paths.front();
  path.pose = [pose = path.pose, from_s](Holding holding, double t_s) { return pose(holding, from_s + t_s); };
  path.duration_s = to_s - from_s;
  return path;
}

TEST(CaseErrors, FallWithTheVoxelSize) {
  for (const char* name : {"entry", "plunge"}) {
    SCOPED_TRACE(name);
    for (const Holding holding : {Holding::kHand, Holding::kPath}) {
      SCOPED_TRACE(ToString(holding));
      // Both sections start in the air, shortly before contact. The handle is faster than the tool on a path.
      const StudyPath path = holding == Holding::kHand ? MakeStretch(name, 0, 0.3) : MakeStretch(name, 0.1, 0.5);
      StudySettings settings;
      settings.rate_hz = 8000;  // at 1000 Hz the error of the time step is larger than that of the voxels
      const StudyReference reference = MakeStudyReference(path, holding, settings, kTolerance, "", nullptr);
      EXPECT_LE(reference.record.error_bar, kTolerance);
      EXPECT_GT(reference.removed_mm3, 0.05);
      const CaseOutcome fine = RunForErrors(path, holding, settings, reference);
      settings.voxel_mm = 0.2;
      const CaseOutcome coarse = RunForErrors(path, holding, settings, reference);
      ASSERT_EQ(fine.state, CaseState::kDone) << fine.why;
      ASSERT_EQ(coarse.state, CaseState::kDone) << coarse.why;
      // The error decreases with at least first order in the voxel size. The onset of contact, a quarter of a voxel
      // early, causes most of the error in these short sections.
      EXPECT_LT(fine.errors->force_l2, 0.7 * coarse.errors->force_l2);
      EXPECT_LT(fine.errors->force_l2, 0.12);
      EXPECT_LT(fine.errors->surface_mean_mm, 0.7 * coarse.errors->surface_mean_mm);
      EXPECT_LT(fine.errors->surface_mean_mm, 0.03);  // shallow: mostly corners, each rounded by a third of a voxel
      EXPECT_LT(fine.errors->direction_p95_deg, 9);
      EXPECT_LT(fine.errors->volume, coarse.errors->volume);
    }
  }
}

// The bone that the disc overlaps at the start is removed both in the simulation and in the reference. Only the onset
// of contact could differ, and it is before the start.
TEST(CaseErrors, HandHeldToolThatStartsInBoneAgreesWithTheReference) {
  const StudyPath path = MakeStretch("plunge", 0.2, 0.5);
  const StudyReference reference = MakeStudyReference(path, Holding::kHand, {}, kTolerance, "", nullptr);
  const CaseOutcome outcome = RunForErrors(path, Holding::kHand, {}, reference);
  ASSERT_EQ(outcome.state, CaseState::kDone) << outcome.why;
  EXPECT_GT(reference.removed_mm3, 3);
  EXPECT_LT(outcome.errors->volume, kTolerance);
  EXPECT_LT(outcome.errors->force_l2, kTolerance);
  EXPECT_LT(outcome.errors->surface_mean_mm, 0.03);  // as above
}

// The errors are measured against cells of 0.05 mm and are of first order: halving the cell removes at least half of
// the error. They are measured next to the kerf, because at its edge the temperature does not converge.
TEST(CaseErrors, OfTheTemperatureFallWithTheCellSize) {
  const StudyPath path = MakeStretch("slot", 0.5, 1.3);
  StudySettings settings;
  settings.voxel_mm = 0.2;
  const StudyReference reference = MakeStudyReference(path, Holding::kPath, settings, 0.1, "", nullptr);
  std::vector<double> errors_K;
  for (const double cell_mm : {0.4, 0.2}) {
    settings.heat_grid_mm = cell_mm;
    const CaseOutcome outcome = RunForErrors(path, Holding::kPath, settings, reference);
    ASSERT_EQ(outcome.state, CaseState::kDone) << outcome.why;
    errors_K.push_back(outcome.errors->temperature_K.value());
    EXPECT_GT(errors_K.back(), outcome.errors->temperature_bar_K.value());
    EXPECT_GT(outcome.errors->temperature_bar_K.value(), 0);
  }
  EXPECT_LT(errors_K[1], 0.7 * errors_K[0]);
}

TEST(CaseErrors, AreZeroOnTheIdlePath) {
  const StudyPath path = MakeStretch("idle", 0, 0.2);
  for (const Holding holding : path.holdings) {
    const StudyReference reference = MakeStudyReference(path, holding, {}, kTolerance, "", nullptr);
    const CaseOutcome outcome = RunForErrors(path, holding, {}, reference);
    ASSERT_EQ(outcome.state, CaseState::kDone) << outcome.why;
    EXPECT_EQ(outcome.errors->force_worst_N, 0);
    EXPECT_EQ(outcome.errors->volume, 0);
  }
}

TEST(CaseErrors, FailureIsRecordedWithItsMessage) {
  StudyPath path = MakeStretch("idle", 0, 0.1);
  const StudyReference reference = MakeStudyReference(path, Holding::kPath, {}, kTolerance, "", nullptr);
  path.make_bone = [](double, int) -> Bone { throw Error("no bone today"); };
  const CaseOutcome outcome = RunForErrors(path, Holding::kPath, {}, reference);
  EXPECT_EQ(outcome.state, CaseState::kFailed);
  EXPECT_EQ(outcome.why, "no bone today");
  EXPECT_FALSE(outcome.errors);
}

// The path has two strokes side by side in a block that continues on both sides, with the tool lifted in between. The
// second stroke cuts like the first, 3 mm (12 voxels) next to it. In the reference the results are equal except for
// rounding and, in the coupled case, the tolerance of its solver.
TEST(CaseErrors, StrokeAfterALiftIsAsInFreshBone) {
  const test::Folder folder;
  const std::string first =
      test::BlockToml({12, 9, 3}, 0.25) + test::StrokeToml({0, -1.5, 11.2}, {0, -1.5, 10.1}, 4.4, {0, 1, 0});
  const std::string file = folder.file("strokes.toml");
  WriteTextFile(folder.file("first.toml"), first);
  WriteTextFile(file, first + test::StrokeToml({0, 1.5, 11.2}, {0, 1.5, 10.1}, 4.4, {0, 1, 0}));
  const StudyPath one = MakeScenePath("first", folder.file("first.toml"));
  EXPECT_TRUE(one.lifts_s.empty());
  const StudyPath path = MakeScenePath("both", file);
  ASSERT_EQ(path.lifts_s.size(), 1u);
  EXPECT_NEAR(path.duration_s, 0.5, 1e-12);
  StudySettings settings;
  settings.voxel_mm = 0.25;
  for (const Holding holding : path.holdings) {
    SCOPED_TRACE(ToString(holding));
    const StudyReference reference = MakeStudyReference(path, holding, settings, 0.05, "", nullptr);
    ASSERT_EQ(reference.ticks.size(), 2000u);
    double max_N = 0;
    for (std::size_t i = 1; i < 1000; ++i) {
      const Vec3& f = reference.ticks[i].f_W_N;
      max_N = std::max(max_N, glm::length(f));
      EXPECT_LT(glm::distance(reference.ticks[1000 + i].f_W_N, f), 1e-6) << i;
    }
    EXPECT_GT(max_N, 0.5);
    const CasePass pass = RunCasePass(path, holding, settings);
    ASSERT_EQ(pass.f_W_N.size(), 500u);
    EXPECT_EQ(pass.f_W_N[250], Vec3(0));  // after the tool was set down
    for (std::size_t i = 1; i < 250; ++i) {
      EXPECT_LT(glm::distance(pass.f_W_N[250 + i], pass.f_W_N[i]), 1e-3 * max_N) << i;
    }
    // Both kerfs are present, so the volume is twice that of one.
    EXPECT_NEAR(pass.removed_mm3, 2 * RunCasePass(one, holding, settings).removed_mm3, 1e-2 * pass.removed_mm3);
    EXPECT_NEAR(reference.removed_mm3, 2 * MakeStudyReference(one, holding, settings, 0.05, "", nullptr).removed_mm3,
                1e-2 * reference.removed_mm3);
  }
}

TEST(StudyReference, SettingsThatDifferOnlyInNumericsShareOne) {
  StudySettings settings;
  EXPECT_EQ(VariantOf(settings), "law=two_component");
  settings.law = "hertz_chip";
  EXPECT_EQ(VariantOf(settings), "");
  settings.voxel_mm = 0.2;
  settings.method = "slab";
  settings.heat_grid_mm = 0.4;
  EXPECT_EQ(VariantOf(settings), "");
  settings.law = "edge_plus_chip";
  EXPECT_EQ(VariantOf(settings), "law=edge_plus_chip");
  settings.material = "uniform";
  EXPECT_EQ(VariantOf(settings), "law=edge_plus_chip,material=uniform");
}

TEST(StudyReference, IsReadBackUnchangedAndOnlyForTheSameInput) {
  const test::Folder folder;
  const std::string file = folder.file("stored.ref");
  const StudyPath path = MakeStretch("entry", 0.25, 0.35);
  const StudyReference made = MakeStudyReference(path, Holding::kPath, {}, kTolerance, file, nullptr);
  ASSERT_TRUE(std::filesystem::exists(file));
  const auto written = std::filesystem::last_write_time(file);
  const StudyReference read = MakeStudyReference(path, Holding::kPath, {}, kTolerance, file, nullptr);
  EXPECT_EQ(std::filesystem::last_write_time(file), written);
  EXPECT_EQ(read.record.input_hash, made.record.input_hash);
  EXPECT_EQ(read.record.force_hash, made.record.force_hash);
  EXPECT_EQ(read.record.steps_per_tick, made.record.steps_per_tick);
  EXPECT_EQ(read.record.error_bar, made.record.error_bar);
  EXPECT_EQ(read.record.seconds, made.record.seconds);
  EXPECT_EQ(read.removed_mm3, made.removed_mm3);
  ASSERT_EQ(read.ticks.size(), made.ticks.size());
  EXPECT_EQ(read.ticks.back().f_W_N, made.ticks.back().f_W_N);
  const CaseOutcome a = RunForErrors(path, Holding::kPath, {}, made);
  const CaseOutcome b = RunForErrors(path, Holding::kPath, {}, read);
  EXPECT_EQ(a.errors->force_l2, b.errors->force_l2);
  EXPECT_EQ(a.errors->surface_max_mm, b.errors->surface_max_mm);

  EXPECT_TRUE(ReadStudyReference(file, made.record.input_hash));
  EXPECT_FALSE(ReadStudyReference(file, made.record.input_hash + 1));
  EXPECT_FALSE(ReadStudyReference(file + ".none", made.record.input_hash));
  // A reference for another law or path must not be used.
  StudySettings law;
  law.law = "edge_plus_chip";
  EXPECT_NE(MakeStudyReference(path, Holding::kPath, law, kTolerance, "", nullptr).record.input_hash,
            made.record.input_hash);
  const StudyPath later = MakeStretch("entry", 0.26, 0.36);
  EXPECT_NE(MakeStudyReference(later, Holding::kPath, {}, kTolerance, "", nullptr).record.input_hash,
            made.record.input_hash);
}

TEST(StudyReference, DamagedFileIsReplacedAndReported) {
  const test::Folder folder;
  const std::string file = folder.file("damaged.ref");
  const StudyPath path = MakeStretch("entry", 0.25, 0.3);
  const StudyReference made = MakeStudyReference(path, Holding::kPath, {}, kTolerance, file, nullptr);
  const std::string whole = ReadTextFile(file);
  for (const std::size_t at : {std::size_t{3}, whole.size() / 2, whole.size() - 2}) {
    std::string text = whole;
    text[at] = static_cast<char>(text[at] ^ 4);
    WriteTextFile(file, text);
    EXPECT_THROW(ReadStudyReference(file, made.record.input_hash), Error);
  }
  WriteTextFile(file, whole.substr(0, whole.size() / 3));
  const StudyReference again = MakeStudyReference(path, Holding::kPath, {}, kTolerance, file, nullptr);
  EXPECT_THAT(again.record.note, testing::HasSubstr("damaged"));
  EXPECT_EQ(again.record.force_hash, made.record.force_hash);
  EXPECT_NO_THROW(ReadStudyReference(file, made.record.input_hash));
}

TEST(StudyReference, StopsOnRequest) {
  const std::atomic<bool> stop{true};
  const StudyPath path = MakeStretch("idle", 0, 0.1);
  for (const Holding holding : {Holding::kHand, Holding::kPath}) {
    EXPECT_THROW(MakeStudyReference(path, holding, {}, kTolerance, "", &stop), Error);
  }
}

}  // namespace
}  // namespace kerf
