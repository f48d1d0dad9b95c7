// Tests that a study is read back as it was written.
#include "experiment/study/study_csv.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "experiment/study/made_up_study.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_columns.h"
#include "support/folder.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using ::testing::HasSubstr;

void Write(const StudyResults& study, const std::string& folder) {
  test::WriteBytes(folder + "/cases.csv", FormatCsv(CaseColumns(), study.cases));
  test::WriteBytes(folder + "/cases_times.csv", FormatCsv(BucketColumns(), ListBuckets(study)));
  test::WriteBytes(folder + "/references.csv", FormatCsv(ReferenceColumns(), study.references));
  test::WriteBytes(folder + "/study.json", FormatStudyJson(study, {}));
}

// The four texts together contain every figure in its shortest exact form, so equal texts mean equal studies.
std::string AllOf(const StudyResults& study) {
  return FormatCsv(CaseColumns(), study.cases) + FormatCsv(BucketColumns(), ListBuckets(study)) +
         FormatCsv(ReferenceColumns(), study.references) + FormatStudyJson(study, {});
}

TEST(StudyCsv, ReadsBackWhatItWrote) {
  const Folder folder;
  const StudyResults study = test::MakeStudy();
  Write(study, folder.path());
  const StudyResults again = ReadStudyResults(folder.path());
  EXPECT_EQ(AllOf(again), AllOf(study));
  ASSERT_EQ(again.cases.size(), study.cases.size());
  // Checks some fields directly: a field that is written but not read back could pass the comparison above.
  EXPECT_EQ(again.cases[3].errors->surface_p95_mm, study.cases[3].errors->surface_p95_mm);
  EXPECT_EQ(again.cases[3].costs->tick.p999_us, study.cases[3].costs->tick.p999_us);
  EXPECT_EQ(again.cases[3].costs->histogram, study.cases[3].costs->histogram);
  EXPECT_EQ(again.references[2].error_bar, study.references[2].error_bar);
  EXPECT_EQ(again.path_titles, study.path_titles);
  EXPECT_EQ(again.machine.cpu, study.machine.cpu);
  EXPECT_EQ(ShowSettings(again.base), ShowSettings(study.base));
}

// Folders of versions before the signed impulse lack that column; everything else is read.
TEST(StudyCsv, AnEarlierVersionsTableIsRead) {
  const Folder folder;
  StudyResults study = test::MakeStudy();
  for (CaseRecord& record : study.cases) {
    if (record.errors) record.errors->impulse_signed.reset();
  }
  Write(study, folder.path());
  std::string text = test::ReadBytes(folder.file("cases.csv"));
  const std::string name = ",impulse_signed";
  const std::size_t at = text.find(name);
  ASSERT_NE(at, std::string::npos);
  const auto column = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at) + 1, ',');
  std::string old;
  std::size_t line_start = 0;
  while (line_start < text.size()) {
    const std::size_t line_end = text.find('\n', line_start);
    std::string line = text.substr(line_start, line_end - line_start);
    std::size_t comma = 0;
    bool quoted = false;
    std::ptrdiff_t commas = 0;
    for (; comma < line.size(); ++comma) {
      quoted = quoted != (line[comma] == '"');
      if (line[comma] == ',' && !quoted && ++commas == column) break;
    }
    line.erase(comma, line_start == 0 ? name.size() : 1);
    old += line + "\n";
    line_start = line_end + 1;
  }
  test::WriteBytes(folder.file("cases.csv"), old);
  const StudyResults again = ReadStudyResults(folder.path());
  EXPECT_EQ(AllOf(again), AllOf(study));
  EXPECT_FALSE(again.cases[3].errors->impulse_signed);
}

TEST(StudyCsv, OddWordsAndNumbersSurvive) {
  const bool holds = rc::check([] {
    const Folder folder;
    StudyResults study;
    const std::string words = "a \"'\\,#;\t\n\r\xc3\xa9\xe2\x82\xac<&>|";
    const auto draw_words = [&] {
      const auto picks = *rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(0, words.size()));
      std::string text;
      for (const std::size_t i : picks) text += words[i] < 0 ? std::string("\xc3\xa9") : std::string(1, words[i]);
      return text;
    };
    const auto number = [] { return static_cast<double>(*rc::gen::arbitrary<float>()) * 1.1; };
    study.title = draw_words();
    study.command = draw_words();
    study.path_titles["x"] = draw_words();
    CaseRecord record;
    record.id = "one";
    record.path = "x";
    record.knob = "law";
    record.value = draw_words();
    record.why = draw_words();
    record.state = CaseState::kFailed;
    record.force_hash = *rc::gen::arbitrary<std::uint64_t>();
    ErrorFigures errors;
    for (const ErrorColumn& column : kErrorColumns) errors.*column.value = number();
    errors.breakthrough_ms = number();
    errors.impulse_signed = number();
    record.errors = errors;
    study.cases.push_back(record);
    ReferenceRecord reference;
    reference.note = draw_words();
    reference.error_bar = number();
    study.references.push_back(reference);
    Write(study, folder.path());
    const StudyResults again = ReadStudyResults(folder.path());
    // Control characters become spaces in the tables; JSON keeps them.
    const auto flat = [](std::string text) {
      std::replace_if(
          text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
      return text;
    };
    RC_ASSERT(again.title == study.title);
    RC_ASSERT(again.command == study.command);
    RC_ASSERT(again.path_titles == study.path_titles);
    RC_ASSERT(again.cases.at(0).value == flat(record.value));
    RC_ASSERT(again.cases.at(0).why == flat(record.why));
    RC_ASSERT(again.cases.at(0).force_hash == record.force_hash);
    const ErrorFigures read = again.cases.at(0).errors.value();
    for (const ErrorColumn& column : kErrorColumns) {
      const double value = read.*column.value;
      RC_ASSERT(value == errors.*column.value);
    }
    RC_ASSERT(again.cases.at(0).errors->breakthrough_ms == errors.breakthrough_ms);
    RC_ASSERT(again.cases.at(0).errors->impulse_signed == errors.impulse_signed);
    RC_ASSERT(!again.cases.at(0).costs);
    RC_ASSERT(again.references.at(0).note == flat(reference.note));
    RC_ASSERT(again.references.at(0).error_bar == reference.error_bar);
  });
  EXPECT_TRUE(holds);
}

TEST(StudyCsv, NonFiniteFiguresAreReadBack) {
  const Folder folder;
  StudyResults study;
  study.cases.push_back(test::MakeCase(Holding::kHand, "x", "default", "", 0, 0.02, 100));
  study.cases[0].errors->volume = std::nan("");
  study.cases[0].errors->force_p95 = INFINITY;
  Write(study, folder.path());
  const StudyResults again = ReadStudyResults(folder.path());
  EXPECT_TRUE(std::isnan(again.cases.at(0).errors->volume));
  EXPECT_EQ(again.cases.at(0).errors->force_p95, INFINITY);
}

TEST(StudyCsv, DamageIsReportedWithFileAndLine) {
  const Folder folder;
  StudyResults study;
  study.cases.push_back(test::MakeCase(Holding::kHand, "x", "default", "", 0, 0.02, 100));
  study.cases.push_back(test::MakeCase(Holding::kPath, "x", "law", "other", 0, 0.02, 100));
  study.references.emplace_back();
  const auto message_after = [&](const std::string& name, const std::string& from, const std::string& to) {
    Write(study, folder.path());
    std::string text = test::ReadBytes(folder.file(name));
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    test::WriteBytes(folder.file(name), text);
    return MessageOf([&] { ReadStudyResults(folder.path()); });
  };
  EXPECT_THAT(message_after("cases.csv", "\npath-x-law-other,path", "\nhand-x-default-,path"),
              HasSubstr("cases.csv:3: the case \"hand-x-default-\" is present twice"));
  EXPECT_THAT(message_after("cases.csv", ",hand,", ",foot,"),
              HasSubstr("cases.csv:2: holding = \"foot\" is neither \"hand\" nor \"path\""));
  EXPECT_THAT(message_after("cases.csv", ",law,", ",lwa,"), HasSubstr("cases.csv:3: there is no knob \"lwa\""));
  EXPECT_THAT(message_after("cases.csv", ",done,", ",gone,"), HasSubstr("cases.csv:2: state = \"gone\""));
  EXPECT_THAT(message_after("cases.csv", ",0.05,", ",O.05,"), HasSubstr("\"O.05\" is not a number"));
  EXPECT_THAT(message_after("cases.csv", ",0.02,", ",0.03,"),
              HasSubstr("cases.csv:2: force_p95_jnd = 0.2857142857142857 is not force_p95 = 0.03"));
  EXPECT_THAT(message_after("cases.csv", "force_p95", "force_p59"), HasSubstr("did you mean"));
  EXPECT_THAT(message_after("cases.csv", ",100000,100000,", ",,100000,"), HasSubstr("in a row that has no costs"));
  EXPECT_THAT(message_after("cases.csv", "0123456789abcdef", "0123456789abcdeg"),
              HasSubstr("is not a whole number in base 16"));
  EXPECT_THAT(message_after("cases_times.csv", "hand-x-default-,300", "hand-y-default-,300"),
              HasSubstr("cases_times.csv:2: there is no case \"hand-y-default-\""));
  EXPECT_THAT(message_after("cases_times.csv", ",300,", ",301,"), HasSubstr("is not the upper edge of bucket 301"));
  EXPECT_THAT(message_after("cases_times.csv", ",300,", ",99999,"), HasSubstr("bucket = 99999 is not one of"));
  EXPECT_THAT(message_after("references.csv", "error_bar_l2,", ""), HasSubstr("references.csv:1:"));
  EXPECT_THAT(message_after("study.json", "\"schema\": 1", "\"schema\": 7"), HasSubstr("schema 7 is not supported"));
  EXPECT_THAT(message_after("study.json", "\"seconds\": 0.0", "\"seconds\": \"long\""),
              HasSubstr("study.json: \"seconds\" = "));
  EXPECT_THAT(message_after("study.json", "\"title\"", "\"tilte\""), HasSubstr("study.json: \"title\" is missing"));
  EXPECT_THAT(message_after("study.json", "\"name\": \"\",", "\"name\": \"\""), HasSubstr("this is not JSON"));
  Write(study, folder.path());
  std::filesystem::remove(folder.file("cases.csv"));
  EXPECT_THAT(MessageOf([&] { ReadStudyResults(folder.path()); }), HasSubstr("cases.csv"));
}

}  // namespace
}  // namespace kerf
