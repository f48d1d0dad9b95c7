#include "experiment/study/merge.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "experiment/study/engine.h"
#include "kerf/error.h"
#include "quick_work.h"
#include "support/folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kMergeRecords = 32;

class StudyMerge : public ::testing::Test {
 protected:
  std::string RunShard(const std::string& out, int index, int count, const std::string& text = test::kQuickStudy) {
    test::QuickWorkLog log;
    StudyRunOptions options;
    options.folder = folder_.file(out);
    options.shard = Shard{index, count};
    options.jobs = 1;
    RunStudy(test::QuickSpec(text), test::MakeQuickWork(log), options);
    return FolderOfShard(options.folder, *options.shard);
  }
  void RunShards(const std::string& out, int count) {
    for (int i = 0; i < count; ++i) RunShard(out, i, count);
  }
  std::set<std::string> RunWhole() {
    test::QuickWorkLog log;
    StudyRunOptions options;
    options.folder = folder_.file("whole");
    RunStudy(test::QuickSpec(), test::MakeQuickWork(log), options);
    return test::ReadAllRecords(options.folder);
  }
  MergeOutcome Merge(const std::vector<std::string>& folders, const std::string& out) {
    warnings_.clear();
    return MergeShards(folders, folder_.file(out), test::MakeQuickWork(log_).variant_of,
                       [this](const std::string& what) { warnings_.push_back(what); });
  }
  std::string Fault(const std::vector<std::string>& folders, const std::string& out) {
    return test::MessageOf([&] { Merge(folders, out); });
  }

  test::Folder folder_;
  test::QuickWorkLog log_;
  std::vector<std::string> warnings_;
};

TEST_F(StudyMerge, MergedShardsEqualTheStudy) {
  const std::set<std::string> whole = RunWhole();
  for (const int count : {1, 3, 20}) {
    const std::string out = "out_" + std::to_string(count);
    RunShards(out, count);
    const MergeOutcome outcome = Merge({}, out);
    EXPECT_THAT(outcome.missing, IsEmpty());
    EXPECT_EQ(outcome.shards, static_cast<std::size_t>(count));
    EXPECT_EQ(outcome.records, kMergeRecords);
    EXPECT_EQ(outcome.twice, 0u);
    EXPECT_EQ(test::ReadAllRecords(folder_.file(out)), whole);
    // Merging again changes nothing.
    EXPECT_THAT(Merge({}, out).missing, IsEmpty());
    EXPECT_EQ(test::ReadAllRecords(folder_.file(out)), whole);
  }
}

TEST_F(StudyMerge, NamedFoldersAndTheirParentsGiveTheSameResult) {
  const std::set<std::string> whole = RunWhole();
  RunShards("shards", 3);
  const std::string parent = folder_.file("shards");
  Merge({parent}, "out");
  EXPECT_EQ(test::ReadAllRecords(folder_.file("out")), whole);
  const MergeOutcome outcome =
      Merge({parent + "/shard-2-of-3", parent + "/shard-0-of-3", parent + "/shard-1-of-3"}, "out_2");
  EXPECT_THAT(outcome.missing, IsEmpty());
  EXPECT_EQ(test::ReadAllRecords(folder_.file("out_2")), whole);
}

TEST_F(StudyMerge, MissingShardIsNamedWithItsCases) {
  RunShards("out", 4);
  const StudyPlan plan = MakePlan(test::QuickSpec(), test::MakeQuickWork(log_).variant_of);
  const auto lost = SplitPlan(plan, 4)[2];
  fs::remove_all(folder_.file("out/shard-2-of-4"));
  const MergeOutcome outcome = Merge({}, "out");
  ASSERT_EQ(outcome.missing.size(), 1u);
  EXPECT_THAT(outcome.missing[0],
              HasSubstr("shard 2/4 is missing: " + std::to_string(lost.size()) + " cases: " + plan.cases[lost[0]].id));
  // The results list the missing shard too, and it can be added later.
  const StudyResults results =
      CollectResults(StudyFolder(folder_.file("out")), test::MakeQuickWork(log_).variant_of, {});
  std::size_t omitted = 0;
  for (const CaseRecord& c : results.cases) omitted += c.state == CaseState::kOmitted ? 1 : 0;
  EXPECT_EQ(omitted, lost.size());
  RunShard("out", 2, 4);
  EXPECT_THAT(Merge({}, "out").missing, IsEmpty());
  EXPECT_EQ(test::ReadAllRecords(folder_.file("out")), RunWhole());
}

TEST_F(StudyMerge, IncompleteShardIsNamed) {
  RunShards("out", 2);
  const StudyPlan plan = MakePlan(test::QuickSpec(), test::MakeQuickWork(log_).variant_of);
  const std::string id = plan.cases[SplitPlan(plan, 2)[1].back()].id;
  fs::remove(StudyFolder(folder_.file("out/shard-1-of-2")).FileOf(id, CaseWork::kCosts));
  EXPECT_THAT(Merge({}, "out").missing, ElementsAre("shard 1/2 is not complete: 1 case: " + id));
}

TEST_F(StudyMerge, DamagedRecordCountsAsMissing) {
  RunShards("out", 2);
  const StudyPlan plan = MakePlan(test::QuickSpec(), test::MakeQuickWork(log_).variant_of);
  const std::string id = plan.cases[SplitPlan(plan, 2)[0].front()].id;
  test::WriteBytes(StudyFolder(folder_.file("out/shard-0-of-2")).FileOf(id, CaseWork::kErrors), "{");
  EXPECT_THAT(Merge({}, "out").missing, ElementsAre("shard 0/2 is not complete: 1 case: " + id));
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("it counts as missing")));
}

TEST_F(StudyMerge, RepeatedShardDoesNotCountTwice) {
  const std::set<std::string> whole = RunWhole();
  RunShards("a", 3);
  const std::string again = RunShard("b", 1, 3);
  const MergeOutcome outcome = Merge({folder_.file("a"), again, again}, "out");
  EXPECT_THAT(outcome.missing, IsEmpty());
  EXPECT_EQ(outcome.records, kMergeRecords);
  const StudyPlan plan = MakePlan(test::QuickSpec(), test::MakeQuickWork(log_).variant_of);
  EXPECT_EQ(outcome.twice, 2 * SplitPlan(plan, 3)[1].size());  // errors and costs
  EXPECT_EQ(test::ReadAllRecords(folder_.file("out")), whole);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_THAT(warnings_[0], HasSubstr("shard 1/3 is present twice, in "));
}

TEST_F(StudyMerge, SplitsOfSeveralKindsOverlapAndAddUp) {
  RunShard("a", 0, 2);
  RunShard("b", 1, 3);
  RunShard("b", 2, 3);
  const MergeOutcome outcome = Merge({folder_.file("a"), folder_.file("b")}, "out");
  EXPECT_THAT(outcome.missing, IsEmpty());  // a half and two thirds
  EXPECT_GT(outcome.twice, 0u);
  EXPECT_EQ(outcome.records, kMergeRecords);
}

TEST_F(StudyMerge, ContradictionIsAnErrorThatNamesBothAndWritesNothing) {
  RunShards("a", 2);
  const std::string again = RunShard("b", 0, 2);
  const StudyPlan plan = MakePlan(test::QuickSpec(), test::MakeQuickWork(log_).variant_of);
  const StudyFolder changed(again);
  const std::string id = plan.cases[SplitPlan(plan, 2)[0].front()].id;
  WorkRecord record = *changed.Read(id, CaseWork::kErrors);
  record.force_hash ^= 1;
  changed.Write(record);
  const std::string message = Fault({folder_.file("a"), again}, "out");
  EXPECT_THAT(message, HasSubstr(folder_.file("a") + "/shard-0-of-2/cases/" + id + ".errors.json and " +
                                 changed.FileOf(id, CaseWork::kErrors) + " contradict each other"));
  EXPECT_FALSE(fs::exists(folder_.file("out/plan.json")));
  // Times may differ; the first one is kept.
  record.force_hash ^= 1;
  record.seconds += 1;
  changed.Write(record);
  EXPECT_THAT(Merge({folder_.file("a"), again}, "out").missing, IsEmpty());
}

// A record of a version without the signed impulse contradicts nothing, and the record that contains the impulse is
// kept.
TEST_F(StudyMerge, RecordsOfAnEarlierVersionAgree) {
  RunShards("a", 1);
  const std::string again = RunShard("b", 0, 1);
  const StudyFolder newer(again);
  WorkRecord record = *newer.Read("slot.hand.default", CaseWork::kErrors);
  ASSERT_FALSE(record.errors->impulse_signed);
  record.errors->impulse_signed = -0.02;
  newer.Write(record);
  for (const bool older_first : {true, false}) {
    const std::string out = older_first ? "out_1" : "out_2";
    const std::string a = folder_.file("a/shard-0-of-1");
    EXPECT_THAT(Merge(older_first ? std::vector{a, again} : std::vector{again, a}, out).missing, IsEmpty());
    EXPECT_EQ(StudyFolder(folder_.file(out)).Read("slot.hand.default", CaseWork::kErrors)->errors->impulse_signed,
              -0.02);
  }
}

TEST_F(StudyMerge, ReferencesThatContradictAreRefused) {
  RunShards("a", 2);
  const std::string again = RunShard("b", 0, 2);
  const StudyFolder changed(again);
  const StudyPlan plan = MakePlan(test::QuickSpec(), test::MakeQuickWork(log_).variant_of);
  StoredReference kept = *changed.ReadReference(plan.cases[SplitPlan(plan, 2)[0].front()].reference);
  kept.record.force_hash ^= 1;
  changed.WriteReference(kept);
  EXPECT_THAT(Fault({folder_.file("a"), again}, "out"), HasSubstr("contradict each other"));
}

TEST_F(StudyMerge, SuccessfulRecordIsPreferredToAFailedOne) {
  RunShards("a", 1);
  const std::string again = RunShard("b", 0, 1);
  const StudyFolder changed(folder_.file("a/shard-0-of-1"));
  WorkRecord record = *changed.Read("slot.hand.default", CaseWork::kCosts);
  record.state = CaseState::kFailed;
  record.why = "not enough memory";
  record.costs.reset();
  changed.Write(record);
  Merge({folder_.file("a"), again}, "out");
  EXPECT_EQ(StudyFolder(folder_.file("out")).Read("slot.hand.default", CaseWork::kCosts)->state, CaseState::kDone);
}

TEST_F(StudyMerge, DifferentStudiesAreRefused) {
  const std::string a = RunShard("a", 0, 2);
  const std::string b = RunShard("b", 1, 2, "[study]\npaths = [\"slot\"]\n");
  const std::string message = Fault({a, b}, "out");
  EXPECT_THAT(message, HasSubstr(a));
  EXPECT_THAT(message, HasSubstr(b));
  EXPECT_THAT(message, HasSubstr("belong to different studies"));
  Merge({a}, "out");
  EXPECT_THAT(Fault({b}, "out"), HasSubstr("holds the results of another study"));
}

TEST_F(StudyMerge, FoldersWithoutAShardAreRefused) {
  fs::create_directories(folder_.file("empty"));
  EXPECT_THAT(Fault({folder_.file("empty")}, "out"), HasSubstr("empty: contains no shard of a study"));
  EXPECT_THAT(Fault({}, "out"), HasSubstr("contains no shard of a study"));
  const std::string a = RunShard("a", 0, 1);
  test::WriteBytes(a + "/plan.json", "{\"schema\": 1}");
  EXPECT_THAT(Fault({a}, "out"), HasSubstr("plan.json: is damaged"));
}

}  // namespace
}  // namespace kerf
