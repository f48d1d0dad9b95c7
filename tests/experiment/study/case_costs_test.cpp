#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiment/study/case.h"
#include "experiment/study/case_run.h"
#include "kerf/error.h"

namespace kerf {
namespace {

StudyPath MakeEntry() {
  return MakeStudyPaths({"entry"}, "").paths.front();
}

StudySettings Coarse() {
  StudySettings settings;
  settings.voxel_mm = 0.25;
  return settings;
}

TEST(CaseCosts, CountEveryTickAndReproduceTheForcesOfASinglePass) {
  const StudyPath path = MakeEntry();
  for (const Holding holding : {Holding::kHand, Holding::kPath}) {
    const CaseOutcome outcome = RunForCosts(path, holding, Coarse(), 3000, std::nullopt);
    ASSERT_EQ(outcome.state, CaseState::kDone) << outcome.why;
    ASSERT_TRUE(outcome.costs);
    // The path has 1200 ticks, and only whole passes count.
    EXPECT_EQ(outcome.costs->ticks, 3600U);
    EXPECT_EQ(outcome.costs->tick.count, 3600U);
    std::uint64_t sum = 0;
    for (const auto& [bucket, count] : outcome.costs->histogram) sum += count;
    EXPECT_EQ(sum, 3600U);
    EXPECT_LE(outcome.costs->undisturbed.count, 3600U);
    EXPECT_GT(outcome.costs->tick.p50_us, 0);
    EXPECT_LE(outcome.costs->tick.p50_us, outcome.costs->tick.p99_us);
    EXPECT_GT(outcome.costs->memory_MB, 1);
    EXPECT_GT(outcome.costs->setup_s, 0);
    EXPECT_GT(outcome.costs->whole_s, 0);
    const CasePass pass = RunCasePass(path, holding, Coarse());
    EXPECT_EQ(outcome.force_hash, pass.force_hash);
    EXPECT_EQ(outcome.bone_hash, pass.bone_hash);
  }
}

TEST(CaseCosts, TheSlabHasNoBone) {
  StudySettings settings = Coarse();
  settings.method = "slab";
  const CaseOutcome outcome = RunForCosts(MakeEntry(), Holding::kHand, settings, 2000, std::nullopt);
  ASSERT_EQ(outcome.state, CaseState::kDone) << outcome.why;
  EXPECT_EQ(outcome.bone_hash, 0U);
  EXPECT_NE(outcome.force_hash, 0U);
  EXPECT_LT(outcome.costs->memory_MB, 1);
}

TEST(CaseCosts, MeaninglessSettingsAreOmittedWithTheReason) {
  StudySettings slab = Coarse();
  slab.method = "slab";
  const StudyPath tilt = MakeStudyPaths({"tilt"}, "").paths.front();
  const CaseOutcome leaves_its_plane = RunForCosts(tilt, Holding::kHand, slab, 1000, std::nullopt);
  EXPECT_EQ(leaves_its_plane.state, CaseState::kOmitted);
  EXPECT_THAT(leaves_its_plane.why, testing::HasSubstr("one line"));
  EXPECT_FALSE(leaves_its_plane.costs);

  StudySettings coarse = Coarse();
  coarse.method = "coarse";
  EXPECT_EQ(RunForCosts(tilt, Holding::kPath, coarse, 1000, std::nullopt).state, CaseState::kOmitted);
  StudySettings ct = Coarse();
  ct.material = "ct";
  EXPECT_THAT(RunForCosts(tilt, Holding::kPath, ct, 1000, std::nullopt).why, testing::HasSubstr("CT numbers"));
  StudyPath by_hand = tilt;
  by_hand.holdings = {Holding::kHand};
  EXPECT_EQ(RunForCosts(by_hand, Holding::kPath, Coarse(), 1000, std::nullopt).state, CaseState::kOmitted);
}

TEST(CaseCosts, FailureIsRecordedWithItsMessage) {
  StudyPath path = MakeEntry();
  path.make_bone = [](double, int) -> Bone { throw Error("no bone today"); };
  const CaseOutcome outcome = RunForCosts(path, Holding::kHand, Coarse(), 1000, std::nullopt);
  EXPECT_EQ(outcome.state, CaseState::kFailed);
  EXPECT_EQ(outcome.why, "no bone today");
  EXPECT_FALSE(outcome.costs);

  StudySettings settings = Coarse();
  settings.rate_hz = 1;
  EXPECT_EQ(RunForCosts(MakeEntry(), Holding::kHand, settings, 1000, std::nullopt).state, CaseState::kFailed);
  settings = Coarse();
  settings.law = "hertz";
  EXPECT_EQ(RunForCosts(MakeEntry(), Holding::kPath, settings, 1000, std::nullopt).state, CaseState::kFailed);
  settings = Coarse();
  settings.method = "voxels";
  EXPECT_EQ(RunForCosts(MakeEntry(), Holding::kPath, settings, 1000, std::nullopt).state, CaseState::kFailed);
  settings = Coarse();
  settings.material = "wood";
  EXPECT_EQ(RunForCosts(MakeEntry(), Holding::kPath, settings, 1000, std::nullopt).state, CaseState::kFailed);
}

TEST(CaseCosts, PassesThatDifferAreAFailure) {
  StudyPath path = MakeEntry();
  // The voxel size differs in every bone, so that the passes differ.
  const auto make = path.make_bone;
  path.make_bone = [make, count = std::make_shared<int>(0)](double, int band) {
    return make(++*count % 2 == 0 ? 0.25 : 0.3, band);
  };
  const CaseOutcome outcome = RunForCosts(path, Holding::kPath, Coarse(), 1000, std::nullopt);
  EXPECT_EQ(outcome.state, CaseState::kFailed);
  EXPECT_THAT(outcome.why, testing::HasSubstr("two passes"));
}

}  // namespace
}  // namespace kerf
