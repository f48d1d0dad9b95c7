#include "experiment/study/engine.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "base/files/folder_lock.h"
#include "experiment/study/record_json.h"
#include "kerf/error.h"
#include "quick_work.h"
#include "support/folder.h"

namespace kerf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// There are 16 cases, each with errors and costs, and 8 references.
constexpr std::size_t kRecords = 32;

struct Session {
  explicit Session(std::string folder, const std::function<void(int)>& before = {})
      : work(test::MakeQuickWork(log, before)) {
    options.folder = std::move(folder);
    options.jobs = 2;
    options.warn = [this](const std::string& what) { warnings.push_back(what); };
  }
  StudyRunOutcome Run(const StudySpec& spec = test::QuickSpec()) { return RunStudy(spec, work, options); }

  test::QuickWorkLog log;
  StudyWork work;
  StudyRunOptions options;
  std::vector<std::string> warnings;
};

TEST(StudyEngine, ComputesEachRecordOnceAndCostsOneAtATime) {
  test::Folder folder;
  Session session(folder.file("out"));
  const StudyRunOutcome outcome = session.Run();
  EXPECT_EQ(outcome.made, kRecords);
  EXPECT_EQ(outcome.kept, 0u);
  EXPECT_FALSE(outcome.stopped);
  EXPECT_THAT(outcome.failed, IsEmpty());
  EXPECT_EQ(session.log.errors.size(), kRecords / 2);
  EXPECT_EQ(std::set<std::string>(session.log.errors.begin(), session.log.errors.end()).size(), kRecords / 2);
  EXPECT_EQ(session.log.costs.size(), kRecords / 2);
  EXPECT_EQ(session.log.max_at_once, 1);
  // Each reference is made once and read once for the errors.
  EXPECT_EQ(std::set<std::string>(session.log.references.begin(), session.log.references.end()).size(), 8u);
  EXPECT_THAT(session.warnings, IsEmpty());
}

TEST(StudyEngine, ExistingRecordsAreNotComputedAgain) {
  test::Folder folder;
  Session(folder.file("out")).Run();
  Session again(folder.file("out"));
  const StudyRunOutcome outcome = again.Run();
  EXPECT_EQ(outcome.kept, kRecords);
  EXPECT_EQ(outcome.made, 0u);
  EXPECT_EQ(again.log.works, 0);
  EXPECT_EQ(again.log.references.size(), 0u);
}

TEST(StudyEngine, ContinuesToTheSameResultsAfterAnyStop) {
  test::Folder folder;
  Session(folder.file("whole")).Run();
  const std::set<std::string> whole = test::ReadAllRecords(folder.file("whole"));
  ASSERT_EQ(whole.size(), kRecords);
  for (const int stop_at : {0, 1, 5, 16, 20, 31}) {
    const std::string out = folder.file("stopped_" + std::to_string(stop_at));
    std::atomic<bool> stop{false};
    Session first(out, [&](int number) { stop = number >= stop_at; });
    first.options.stop = &stop;
    const StudyRunOutcome stopped = first.Run();
    EXPECT_TRUE(stopped.stopped) << stop_at;
    EXPECT_LT(stopped.made, kRecords + (stop_at == 31 ? 1 : 0));
    Session second(out);
    const StudyRunOutcome outcome = second.Run();
    EXPECT_EQ(outcome.kept, stopped.made) << stop_at;
    EXPECT_EQ(outcome.kept + outcome.made, kRecords) << stop_at;
    EXPECT_EQ(test::ReadAllRecords(out), whole) << stop_at;
  }
}

TEST(StudyEngine, DamagedAndForeignRecordsAreMadeAgain) {
  test::Folder folder;
  const std::string out = folder.file("out");
  Session(out).Run();
  const std::set<std::string> whole = test::ReadAllRecords(out);
  const StudyFolder records(out);
  const std::string first = records.FileOf("entry.hand.default", CaseWork::kErrors);
  const std::string text = test::ReadBytes(first);
  const std::string other = test::ReadBytes(records.FileOf("slot.hand.default", CaseWork::kErrors));
  for (const std::string& damaged : {std::string(), text.substr(0, text.size() / 2), std::string("{}"),
                                     std::string("[1]"), std::string(100, '\0'), other}) {
    test::WriteBytes(first, damaged);
    Session again(out);
    const StudyRunOutcome outcome = again.Run();
    EXPECT_EQ(outcome.made, 1u) << damaged;
    ASSERT_EQ(again.warnings.size(), 1u) << damaged;
    EXPECT_THAT(again.warnings[0], HasSubstr("entry.hand.default.errors.json: is damaged"));
    EXPECT_EQ(test::ReadAllRecords(out), whole);
  }
  // A damaged reference is made again when a case needs it.
  test::WriteBytes(out + "/references/entry.hand.json", "{");
  std::filesystem::remove(first);
  Session again(out);
  EXPECT_EQ(again.Run().made, 1u);
  EXPECT_THAT(again.warnings, ElementsAre(HasSubstr("references/entry.hand.json: is damaged")));
}

TEST(StudyEngine, RecordsTruncatedAnywhereAreRefused) {
  test::Folder folder;
  Session(folder.file("out")).Run();
  const std::string text =
      test::ReadBytes(StudyFolder(folder.file("out")).FileOf("slot.hand.default", CaseWork::kCosts));
  EXPECT_EQ(FormatWorkRecord(ParseWorkRecord(text)), text);
  for (std::size_t length = 0; length + 2 < text.size(); ++length) {
    EXPECT_THROW(ParseWorkRecord(text.substr(0, length)), Error) << length;
  }
}

TEST(StudyEngine, AnotherStudyInTheFolderIsRefusedOrExtended) {
  test::Folder folder;
  Session(folder.file("out")).Run();
  const StudySpec wider =
      test::QuickSpec(std::string(test::kQuickStudy) + "[[knob]]\nname = \"substeps\"\nvalues = [2]\n");
  Session other(folder.file("out"));
  EXPECT_THAT(test::MessageOf([&] { other.Run(wider); }), HasSubstr("holds the results of another study"));
  EXPECT_EQ(other.log.works, 0);
  other.options.extend = true;
  const StudyRunOutcome outcome = other.Run(wider);
  EXPECT_EQ(outcome.kept, kRecords);
  EXPECT_EQ(outcome.made, 8u);  // one value on two paths in two holdings, errors and costs
}

TEST(StudyEngine, OnlyOneStudyRunsInAFolder) {
  test::Folder folder;
  const FolderLock lock(folder.file("out"));
  Session session(folder.file("out"));
  EXPECT_THAT(test::MessageOf([&] { session.Run(); }), HasSubstr("another kerf is writing results into this folder"));
}

TEST(StudyEngine, FailuresAreRecordedAndTheStudyContinues) {
  test::Folder folder;
  Session session(folder.file("out"), [](int number) {
    if (number == 3) throw Error("it broke");
    if (number == 5) throw std::bad_alloc();
  });
  session.options.jobs = 1;
  const StudyRunOutcome outcome = session.Run();
  EXPECT_EQ(outcome.made, kRecords);
  ASSERT_EQ(outcome.failed.size(), 2u);
  std::set<std::string> why;
  for (const auto& [id, reason] : outcome.failed) why.insert(reason);
  EXPECT_THAT(why, ElementsAre("it broke", "not enough memory"));
  const StudyResults results = CollectResults(StudyFolder(folder.file("out")), session.work.variant_of, {});
  int failed = 0;
  for (const CaseRecord& c : results.cases) failed += c.state == CaseState::kFailed ? 1 : 0;
  EXPECT_EQ(failed, 2);
  // Failed cases are tried again.
  Session again(folder.file("out"));
  const StudyRunOutcome second = again.Run();
  EXPECT_EQ(second.made, 2u);
  EXPECT_THAT(second.failed, IsEmpty());
}

TEST(StudyEngine, OnlyTheCasesOfAMissingReferenceFail) {
  test::Folder folder;
  Session session(folder.file("out"));
  const StudyRunOutcome outcome =
      session.Run(test::QuickSpec("[study]\npaths = [\"slot\"]\nholdings = [\"hand\"]\n[[knob]]\nname = "
                                  "\"law\"\nvalues = [\"hertz_constant_bite\"]\n"));
  ASSERT_EQ(outcome.failed.size(), 1u);
  EXPECT_EQ(outcome.failed[0].first, "slot.hand.law-hertz_constant_bite, errors");
  EXPECT_EQ(outcome.failed[0].second, "there is no reference: this law has no reference");
  EXPECT_EQ(session.log.references.count("slot.hand.law=hertz_constant_bite"), 1u);  // not tried twice
  EXPECT_EQ(session.log.costs.size(), 2u);
}

TEST(StudyEngine, MissingPathsAreLeftOutWithTheReason) {
  test::Folder folder;
  Session session(folder.file("out"));
  const StudyRunOutcome outcome = session.Run(test::QuickSpec("[study]\npaths = [\"absent\", \"idle\"]\n"));
  EXPECT_THAT(outcome.failed, IsEmpty());
  const StudyResults results = CollectResults(StudyFolder(folder.file("out")), session.work.variant_of, {});
  ASSERT_EQ(results.cases.size(), 3u);  // "idle" is not made for the path
  EXPECT_EQ(results.cases[0].id, "absent.hand.default");
  EXPECT_EQ(results.cases[0].state, CaseState::kOmitted);
  EXPECT_EQ(results.cases[0].why, "its data are not there");
  EXPECT_EQ(results.cases[2].id, "idle.hand.default");
  EXPECT_EQ(results.cases[2].state, CaseState::kDone);
}

TEST(StudyEngine, ErrorsAndCostsCanBeComputedSeparately) {
  test::Folder folder;
  Session(folder.file("whole")).Run();
  Session errors(folder.file("out"));
  errors.options.costs = false;
  EXPECT_EQ(errors.Run().made, kRecords / 2);
  EXPECT_EQ(errors.log.costs.size(), 0u);
  Session costs(folder.file("out"));
  costs.options.errors = false;
  EXPECT_EQ(costs.Run().made, kRecords / 2);
  EXPECT_EQ(costs.log.references.size(), 0u);
  EXPECT_EQ(test::ReadAllRecords(folder.file("out")), test::ReadAllRecords(folder.file("whole")));
}

TEST(StudyEngine, ResultsAreThoseOfTheRecords) {
  test::Folder folder;
  Session session(folder.file("out"));
  session.Run();
  const StudyResults results = CollectResults(StudyFolder(folder.file("out")), session.work.variant_of, {});
  EXPECT_EQ(results.title, "Quick");
  EXPECT_THAT(results.paths, ElementsAre("entry", "slot"));
  EXPECT_THAT(results.knobs, ElementsAre("voxel_mm", "law"));
  EXPECT_EQ(results.references.size(), 8u);
  EXPECT_EQ(results.path_titles.at("slot"), "The path slot");
  std::map<std::string, std::map<double, double>> curves;  // id of the curve: number to error
  for (const CaseRecord& c : results.cases) {
    ASSERT_EQ(c.state, CaseState::kDone) << c.id << c.why;
    ASSERT_TRUE(c.errors && c.costs) << c.id;
    if (c.knob != "law")
      curves[c.path + std::string(ToString(c.holding))][c.knob == "default" ? 0.1 : c.number] = c.errors->force_p95;
  }
  ASSERT_EQ(curves.size(), 4u);
  for (const auto& [name, curve] : curves) {
    ASSERT_EQ(curve.size(), 3u) << name;
    for (const auto& [voxel_mm, error] : curve) EXPECT_EQ(error, 0.1 * voxel_mm);  // bit-identical after reading
  }
}

TEST(StudyEngine, EstimateFallsAsRecordsAreAdded) {
  test::Folder folder;
  Session session(folder.file("out"));
  const StudyPlan plan = MakePlan(test::QuickSpec(), session.work.variant_of);
  const StudyEstimate before = EstimateStudy(plan, session.options);
  EXPECT_EQ(before.cases, kRecords / 2);
  EXPECT_EQ(before.references, 8u);
  EXPECT_EQ(before.left, kRecords);
  EXPECT_FALSE(before.measured);
  EXPECT_GT(before.errors_s, 0);
  session.Run();
  const StudyEstimate after = EstimateStudy(plan, session.options);
  EXPECT_EQ(after.left, 0u);
  EXPECT_TRUE(after.measured);
  EXPECT_EQ(after.references_s + after.errors_s + after.costs_s, 0);
}

TEST(StudyEngine, ImpossibleFiguresAreRefused) {
  WorkRecord record;
  record.id = "a";
  record.errors = ErrorFigures{};
  record.errors->breakthrough_ms = -0.5;  // too early
  record.why = "bytes \xff that are no text";
  const WorkRecord again = ParseWorkRecord(FormatWorkRecord(record));
  EXPECT_EQ(again.errors->breakthrough_ms, -0.5);
  EXPECT_FALSE(again.errors->temperature_K.has_value());
  for (const double never : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -3.0}) {
    record.errors->force_l2 = never;
    EXPECT_THAT(test::MessageOf([&] { ParseWorkRecord(FormatWorkRecord(record)); }), HasSubstr("force_l2"));
  }
}

}  // namespace
}  // namespace kerf
