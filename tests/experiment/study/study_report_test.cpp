// Tests of the report of a study.
#include "experiment/study/study_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "experiment/study/made_up_study.h"
#include "experiment/study/study_words.h"
#include "support/folder.h"
#include "support/xml_check.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Returns a study of two knobs, coupled only, because each figure takes a while.
StudyResults MakeShortStudy() {
  StudyResults study = test::MakeStudy();
  study.knobs = {"voxel_mm", "method"};
  std::erase_if(study.cases, [](const CaseRecord& record) {
    const bool kept = record.knob == "default" || record.knob == "voxel_mm" || record.knob == "method";
    return record.holding == Holding::kPath || !kept;
  });
  return study;
}

std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(StudyReport, IsReproducedByteForByteFromItsRawFigures) {
  if (const char* look = std::getenv("KERF_TEST_REPORT_DIR"); look != nullptr)
    WriteStudyReport(test::MakeStudy(), look, {});
  const test::Folder folder;
  std::filesystem::create_directory(folder.file("one"));
  std::filesystem::create_directory(folder.file("two"));
  WriteStudyReport(MakeShortStudy(), folder.file("one"), {});
  WriteStudyReport(ReadStudyResults(folder.file("one")), folder.file("two"), {});
  const std::vector<std::string> names = FilesIn(folder.file("one"));
  EXPECT_EQ(FilesIn(folder.file("two")), names);
  const std::string report = test::ReadBytes(folder.file("one/report.md"));
  std::size_t pictures = 0;
  for (const std::string& name : names) {
    const std::string bytes = test::ReadBytes(folder.file("one/" + name));
    EXPECT_EQ(test::ReadBytes(folder.file("two/" + name)), bytes) << name;
    if (name.ends_with(".svg")) {
      EXPECT_EQ(test::FindXmlFault(bytes), "") << name;
    }
    if (!name.ends_with(".svg") && !name.ends_with(".png")) continue;
    EXPECT_THAT(report, HasSubstr("(" + name + ")"));  // every one appears in the report
    ++pictures;
  }
  EXPECT_EQ(pictures, 16u);
  const std::string diagram = test::ReadBytes(folder.file("one/work_precision_hand.svg"));
  for (const char* words : {">Pareto front<", ">0.25 ms<", ">0.5 ms<", ">1 ms<", ">3.5 %: half a JND<",
                            ">7 %: one JND<", ">0.05<", ">0.8<", ">defaults<", ">slab (9 of 11 paths)<"}) {
    EXPECT_THAT(diagram, HasSubstr(words));
  }
}

TEST(StudyReport, SignedImpulseIsListedNextToTheForce) {
  StudyResults study = test::MakeStudy();
  const std::string table = DefaultsTable(study, Holding::kHand);
  EXPECT_THAT(table, HasSubstr("| path | force, p95 | impulse |"));
  // The signed figure is a fifth of the force's errors of 2.46 and 2.7 %.
  EXPECT_THAT(table, HasSubstr("| slot | 2.46 % | +0.492 % |"));
  EXPECT_THAT(table, HasSubstr("| breakthrough | 2.70 % | -0.540 % |"));
  EXPECT_THAT(DescribeFindings(study, Holding::kHand),
              HasSubstr("**Impulse**: from -0.540 % on `breakthrough` to +0.600 % on `worst`"));
  for (CaseRecord& record : study.cases) {
    if (record.errors) record.errors->impulse_signed.reset();
  }
  EXPECT_THAT(DefaultsTable(study, Holding::kHand), HasSubstr("| slot | 2.46 % | |"));
  EXPECT_THAT(DescribeFindings(study, Holding::kHand), Not(HasSubstr("Impulse")));
}

TEST(StudyReport, EachForceTableNamesTheMinimumForce) {
  const test::Folder folder;
  WriteStudyReport(MakeShortStudy(), folder.path(), {});
  const std::string report = test::ReadBytes(folder.file("report.md"));
  for (const char* heading : {"The defaults, path by path", "The best within a time limit",
                              "The cheapest within an error limit", "Voxels against the slab", "All settings"}) {
    EXPECT_THAT(report, HasSubstr(std::string("### ") + heading + "\n\nForce, p95: 95th percentile of |F - R| / "));
  }
}

TEST(StudyReport, ReportsThatNothingWasDoneAndRemovesOldFigures) {
  const test::Folder folder;
  StudyResults study = MakeShortStudy();
  study.knobs = {"method"};
  std::erase_if(study.cases, [](const CaseRecord& record) { return record.value == "slab" || record.path == "worst"; });
  WriteStudyReport(study, folder.path(), {});
  EXPECT_TRUE(std::filesystem::exists(folder.file("work_precision_hand.png")));
  test::WriteBytes(folder.file("mine.png"), "not the study's");
  for (CaseRecord& record : study.cases) {
    record.state = CaseState::kFailed;
    record.why = "there was no room";
    record.errors.reset(), record.costs.reset();
  }
  WriteStudyReport(study, folder.path(), {});
  const std::string report = test::ReadBytes(folder.file("report.md"));
  EXPECT_THAT(report, HasSubstr("No case was run"));
  EXPECT_THAT(report, HasSubstr("there was no room"));
  EXPECT_FALSE(std::filesystem::exists(folder.file("work_precision_hand.png")));
  EXPECT_TRUE(std::filesystem::exists(folder.file("mine.png")));
}

}  // namespace
}  // namespace kerf
