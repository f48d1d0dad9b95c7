#include "experiment/study/plan.h"

#include <gmock/gmock.h>

#include <numeric>
#include <set>

#include "kerf/error.h"
#include "quick_work.h"
#include "support/folder.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

StudyPlan PlanOf(const std::string& text) {
  test::QuickWorkLog log;
  return MakePlan(test::QuickSpec(text), test::MakeQuickWork(log).variant_of);
}

std::string Sweep(const std::string& knob, const std::string& values) {
  return "[[knob]]\nname = \"" + knob + "\"\nvalues = [" + values + "]\n";
}

TEST(StudyPlan, ContainsEachPathHoldingAndValueOnceAndTheBaseOnce) {
  // The value 0.1 is the base.
  const StudyPlan plan = PlanOf(test::kQuickStudy);
  std::set<std::string> ids;
  for (const PlannedCase& c : plan.cases) EXPECT_TRUE(ids.insert(c.id).second) << c.id;
  const std::set<std::string> expected{"entry.hand.default",
                                       "entry.hand.voxel_mm-0.4",
                                       "entry.hand.voxel_mm-0.2",
                                       "entry.hand.law-edge_plus_chip",
                                       "entry.path.default",
                                       "entry.path.voxel_mm-0.4",
                                       "entry.path.voxel_mm-0.2",
                                       "slot.hand.default",
                                       "slot.hand.voxel_mm-0.4",
                                       "slot.hand.voxel_mm-0.2",
                                       "slot.hand.law-edge_plus_chip",
                                       "slot.path.default",
                                       "slot.path.voxel_mm-0.4",
                                       "slot.path.voxel_mm-0.2",
                                       "entry.path.law-edge_plus_chip",
                                       "slot.path.law-edge_plus_chip"};
  EXPECT_EQ(ids, expected);
}

TEST(StudyPlan, HashChangesWithAnyValue) {
  std::set<std::uint64_t> hashes;
  const std::vector<std::string> texts{"",
                                       Sweep("voxel_mm", "0.2"),
                                       Sweep("voxel_mm", "0.21"),
                                       Sweep("voxel_mm", "0.2, 0.21"),
                                       Sweep("rate_hz", "500"),
                                       "[base]\nsubsteps = 2\n",
                                       "[study]\nticks_of_defaults = 5000\n",
                                       "[study]\nreference_tolerance = 5e-3\n",
                                       "[study]\npaths = [\"slot\"]\n",
                                       "[study]\nholdings = [\"hand\"]\n",
                                       "[study]\ncost_paths = [\"slot\"]\n" + Sweep("voxel_mm", "0.2")};
  for (const std::string& text : texts) {
    EXPECT_TRUE(hashes.insert(PlanOf(text).hash).second) << text;
    EXPECT_EQ(PlanOf("# the same\n" + text).hash, PlanOf(text).hash);
  }
}

TEST(StudyPlan, RestrictedKnobsStayWithinTheirPathsAndHoldings) {
  const StudyPlan plan = PlanOf(Sweep("voxel_mm", "0.2") + "paths = [\"slot\"]\nholdings = [\"path\"]\n");
  int turned = 0;
  for (const PlannedCase& c : plan.cases) turned += c.knob == "voxel_mm" ? 1 : 0;
  EXPECT_EQ(turned, 1);
}

TEST(StudyPlan, ShardsTogetherContainEachCaseOnce) {
  const StudyPlan plan = PlanOf(Sweep("voxel_mm", "0.4, 0.2, 0.15, 0.05") + Sweep("rate_hz", "250, 500, 2000"));
  for (const int count : {1, 2, 3, 7, 8, 64, 1000}) {
    const auto shards = SplitPlan(plan, count);
    ASSERT_EQ(shards.size(), static_cast<std::size_t>(count));
    std::vector<std::size_t> all;
    for (const auto& shard : shards) all.insert(all.end(), shard.begin(), shard.end());
    std::sort(all.begin(), all.end());
    std::vector<std::size_t> expected(plan.cases.size());
    std::iota(expected.begin(), expected.end(), 0u);
    EXPECT_EQ(all, expected) << count;
  }
}

TEST(StudyPlan, ShardsAreOfAboutEqualWeight) {
  std::string values;
  for (int i = 0; i < 200; ++i) values += (i > 0 ? ", " : "") + ShowNumber(0.1 + 0.001 * i);
  const StudyPlan plan = PlanOf(Sweep("voxel_mm", values));
  double whole = 0;
  double heaviest_case = 0;
  const auto weigh = [&](std::size_t i) {
    return plan.cases[i].errors_weight + (plan.cases[i].costs ? plan.cases[i].costs_weight : 0);
  };
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    whole += weigh(i);
    heaviest_case = std::max(heaviest_case, weigh(i));
  }
  constexpr double kReferences = 10 * 8;  // 8 references with a weight of 10 each are balanced as well
  for (const auto& shard : SplitPlan(plan, 8)) {
    double weight = 0;
    for (const std::size_t i : shard) weight += weigh(i);
    // A shard begins and ends within a case, and it may have no reference or two.
    EXPECT_NEAR(weight, whole / 8, heaviest_case + kReferences / 8 + 20);
  }
}

TEST(StudyPlan, ShardIsCountedFromZero) {
  EXPECT_EQ(ToString(ShardFromText("0/8")), "0/8");
  EXPECT_EQ(ToString(ShardFromText("7/8")), "7/8");
  EXPECT_THAT(test::MessageOf([] { ShardFromText("8/8"); }), HasSubstr("counted from 0 (sbatch --array=0-7)"));
  for (const char* text : {"", "1", "/", "1/", "/8", "-1/8", "1/0", "a/b", "1/8x", "1 / 8", "0x1/8", "1/99999999999"}) {
    EXPECT_THAT(test::MessageOf([&] { ShardFromText(text); }), HasSubstr("must be I/N")) << text;
  }
}

}  // namespace
}  // namespace kerf
