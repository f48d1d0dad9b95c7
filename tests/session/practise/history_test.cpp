// Tests of the students' history and of damage to its file.
#include "session/practise/history.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/files/files.h"
#include "kerf/error.h"
#include "session/practise/history_check.h"
#include "support/message_of.h"
#include "support/result_folder.h"

namespace kerf {
namespace {

using testing::HasSubstr;

/// Limits the size of all files that this process writes.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &kept_);
    const rlimit limit{bytes, kept_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &kept_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit kept_{};
  sighandler_t handler_;
};

class HistoryTest : public test::ResultFolderTest {
 protected:
  std::string File() const { return folder_ + "/data/practise.db"; }
  static Attempt MakeOne(const std::string& student, const std::string& hash, double total) {
    ScoreSheet sheet = MakeSheet(ExerciseKind::kGroove);
    SetValue(sheet, "plane_offset_mm", 0.25);
    Attempt a;
    a.student = student;
    a.exercise = "groove";
    a.level = 2;
    a.taken = "2026-11-21T10:00:00Z";
    a.recording = "/tmp/a.kerf";
    a.hash = hash;
    a.total = total;
    a.measures_json = FormatSheetJson(sheet);
    return a;
  }
  std::string MessageOfOpening() const {
    return test::MessageOf([&] { const History history(File()); });
  }
  void Execute(const std::string& sql) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(File().c_str(), &db), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
  }
};

TEST_F(HistoryTest, StoresAttempts) {
  const std::string name = "O'Hara; DROP TABLE attempts; \xc3\xa9";
  {
    History history(File());
    EXPECT_TRUE(history.List().empty());
    EXPECT_TRUE(history.Add(MakeOne(name, "a", 71.5)));
    EXPECT_TRUE(history.Add(MakeOne("Ida", "b", 20)));
    EXPECT_FALSE(history.Add(MakeOne("Ida", "b", 90)));  // the same recording again
    EXPECT_TRUE(history.Add(MakeOne("Ida", "a", 30)));
  }
  const History again(File());
  ASSERT_EQ(again.List().size(), 3U);
  const std::vector<Attempt> of_one = again.List(name);
  ASSERT_EQ(of_one.size(), 1U);
  EXPECT_EQ(of_one[0].student, name);
  EXPECT_EQ(of_one[0].total, 71.5);
  EXPECT_EQ(of_one[0].level, 2);
  EXPECT_EQ(of_one[0].Get("plane_offset_mm"), 0.25);
  EXPECT_FALSE(of_one[0].Get("jitter_mm"));
  EXPECT_EQ(again.List("Ida")[0].total, 20.0);
}

TEST_F(HistoryTest, TwoWritersAtTheSameTimeLoseNothing) {
  constexpr int kEach = 25;
  const auto write = [&](const std::string& student, std::string& failure) {
    try {
      for (int i = 0; i < kEach; ++i) History(File()).Add(MakeOne(student, fmt::format("{}", i), i));
    } catch (const Error& e) {
      failure = e.what();
    }
  };
  std::string failure_a;
  std::string failure_b;
  std::thread a(write, "a", std::ref(failure_a));
  std::thread b(write, "b", std::ref(failure_b));
  a.join();
  b.join();
  EXPECT_EQ(failure_a, "");
  EXPECT_EQ(failure_b, "");
  EXPECT_EQ(History(File()).List().size(), 2U * kEach);
}

TEST_F(HistoryTest, OpensWhileAnotherProgramWritesRepeatedly) {
  History(File()).Add(MakeOne("a", "x", 1));
  for (int i = 0; i < 20; ++i) {
    Execute("PRAGMA journal_mode = DELETE");  // the state before the first opening was complete
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(File().c_str(), &db), SQLITE_OK);
    sqlite3_busy_timeout(db, 5000);
    std::atomic<bool> done{false};
    std::thread other([&] {
      while (!done) {
        sqlite3_exec(db, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        sqlite3_exec(db, "COMMIT", nullptr, nullptr, nullptr);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
    });
    const std::string message = MessageOfOpening();
    done = true;
    other.join();
    sqlite3_close(db);
    ASSERT_EQ(message, "") << i;
  }
}

TEST_F(HistoryTest, ReportsEachFaultOfItsFileInOneSentence) {
  MakeFolder(folder_ + "/data");
  WriteTextFile(File(), std::string(4096, 'x'));
  EXPECT_THAT(MessageOfOpening(), HasSubstr("is not a history of kerf"));
  std::filesystem::remove(File());
  Execute("CREATE TABLE cats (name TEXT)");
  EXPECT_THAT(MessageOfOpening(), HasSubstr("of another program"));
  std::filesystem::remove(File());
  History(File()).Add(MakeOne("Ida", "a", 1));
  Execute("PRAGMA user_version = 7");
  EXPECT_THAT(MessageOfOpening(), HasSubstr("later version of kerf"));
  Execute("PRAGMA user_version = 2");
  EXPECT_EQ(History(File()).List().size(), 1U);
  // The file is cut short, as by a full disk.
  std::filesystem::resize_file(File(), 1000);
  std::filesystem::remove(File() + "-wal");
  EXPECT_NE(MessageOfOpening(), "");
  EXPECT_EQ(MessageOfOpening().find('\n'), std::string::npos);
}

TEST_F(HistoryTest, ChangedRowIsMarkedAndHasNoTotal) {
  {
    History history(File());
    for (const char* hash : {"a", "b", "c", "d"}) history.Add(MakeOne("Ida", hash, 40));
    for (const Attempt& a : history.List()) EXPECT_TRUE(FindMarks(a).empty() && a.graded()) << a.number;
  }
  const auto expect_damaged = [&](const char* change, const char* back) {
    Execute(change);
    const std::vector<Attempt> rows = History(File()).List("Ida");
    ASSERT_EQ(rows.size(), 4U) << change;
    EXPECT_TRUE(rows[1].damaged) << change;
    EXPECT_FALSE(rows[1].graded()) << change;
    EXPECT_FALSE(rows[0].damaged || rows[2].damaged || rows[3].damaged) << change;
    EXPECT_THAT(FormatHistory(rows), HasSubstr("-  DAMAGED in the history")) << change;
    EXPECT_TRUE(nlohmann::json::parse(FormatHistoryJson(rows))[1]["total"].is_null()) << change;
    EXPECT_THAT(FormatTeacherPage(rows), HasSubstr("1 of them is marked")) << change;
    Execute(back);
  };
  expect_damaged("UPDATE attempts SET total = 99 WHERE number = 2", "UPDATE attempts SET total = 40 WHERE number = 2");
  expect_damaged("UPDATE attempts SET student = 'Ole' WHERE number = 2",
                 "UPDATE attempts SET student = 'Ida' WHERE number = 2");
  expect_damaged("UPDATE attempts SET incomplete = 'x' WHERE number = 2",
                 "UPDATE attempts SET incomplete = '' WHERE number = 2");
  EXPECT_TRUE(FindMarks(History(File()).List()[1]).empty());
  // The row that follows a removed one reveals the removal.
  Execute("DELETE FROM attempts WHERE number = 2");
  const std::vector<Attempt> rows = History(File()).List();
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_TRUE(rows[1].follows_change);
  EXPECT_FALSE(rows[0].follows_change || rows[2].follows_change);
}

// After a change to any byte of the file, the file is refused, the row is marked, or the displayed data are unchanged.
TEST_F(HistoryTest, NoChangedByteYieldsAWrongUnmarkedAttempt) {
  {
    History history(File());
    for (const char* hash : {"a", "b", "c"}) history.Add(MakeOne("Ida", hash, 40));
  }
  const std::vector<Attempt> kept = History(File()).List();
  const std::string whole = ReadTextFile(File());
  int refused = 0;
  int marked = 0;
  for (std::size_t at = 0; at < whole.size(); at += 37) {
    std::string content = whole;
    content[at] = static_cast<char>(content[at] ^ (1 << at % 8));
    for (const char* with : {"-wal", "-shm", ""}) std::filesystem::remove(File() + with);
    WriteTextFile(File(), content);
    try {
      std::size_t good = 0;
      for (const Attempt& a : History(File()).List()) {
        if (a.damaged) {
          ++marked;
          continue;
        }
        ++good;
        const auto same = std::find_if(kept.begin(), kept.end(), [&](const Attempt& k) {
          return k.number == a.number && k.student == a.student && k.total == a.total && k.level == a.level &&
                 k.exercise == a.exercise && k.measures_json == a.measures_json && k.hash == a.hash;
        });
        EXPECT_NE(same, kept.end()) << "byte " << at;
      }
      EXPECT_LE(good, kept.size()) << "byte " << at;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(marked, 0);
}

TEST_F(HistoryTest, EarlierVersionIsConvertedCompletelyOrNotAtAll) {
  MakeFolder(folder_ + "/data");
  Execute(
      "CREATE TABLE attempts (number INTEGER PRIMARY KEY, student TEXT NOT NULL, exercise TEXT NOT NULL, "
      "level INTEGER NOT NULL, taken TEXT NOT NULL, recording TEXT NOT NULL, hash TEXT NOT NULL, total REAL, "
      "measures TEXT NOT NULL, UNIQUE (student, hash));"
      "PRAGMA application_id = 1801810534; PRAGMA user_version = 1;"
      "INSERT INTO attempts VALUES (1, 'Ida', 'groove', 1, '2026', '/a.kerf', 'a', 40.5, '{}');"
      "INSERT INTO attempts VALUES (2, 'Ole', 'groove', 1, '2026', '/b.kerf', 'a', 7, '{}');");
  const std::string before = ReadTextFile(File());
  {
    // The limit is enough for the journal's first page, but not for its second.
    const FileSizeLimit limit(8300);
    EXPECT_THAT(MessageOfOpening(), HasSubstr("can't be used"));
  }
  EXPECT_EQ(ReadTextFile(File()), before);
  {
    History history(File());
    const std::vector<Attempt> rows = history.List();
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0].total, 40.5);
    EXPECT_TRUE(rows[0].graded());
    EXPECT_EQ(rows[0].duplicates, std::vector<std::int64_t>{2});  // by the file's hash
    EXPECT_TRUE(history.Add(MakeOne("Ida", "c", 30)));
  }
  for (const Attempt& a : History(File()).List()) EXPECT_FALSE(a.damaged || a.follows_change) << a.number;
  Execute("UPDATE attempts SET total = 50 WHERE number = 1");
  EXPECT_TRUE(History(File()).List()[0].damaged);
}

TEST_F(HistoryTest, DuplicatesAndIncompleteAttemptsAreMarked) {
  History history(File());
  Attempt one = MakeOne("Ida", "a", 40);
  one.steps_digest = "same";
  one.seal = "whole";
  one.signer = std::string(64, 'd');
  Attempt copy = MakeOne("Ole", "b", 40);  // another file with the same ticks
  copy.steps_digest = "same";
  copy.seal = "broken";
  Attempt cut = MakeOne("Ole", "c", 0);
  cut.total.reset();
  cut.steps_digest = "other";
  cut.recording_state = "cut short";
  cut.incomplete = "the recording is cut short";
  for (const Attempt& a : {one, copy, cut}) EXPECT_TRUE(history.Add(a));
  const std::vector<Attempt> rows = history.List();
  EXPECT_THAT(FindMarks(rows[0]), testing::ElementsAre("same recording or beginning as number 2"));
  EXPECT_THAT(FindMarks(rows[1]), testing::ElementsAre("seal broken", "same recording or beginning as number 1"));
  EXPECT_THAT(FindMarks(rows[2]), testing::ElementsAre("not graded: the recording is cut short"));
  // Another student's attempt is also detected in the list of a single student.
  EXPECT_THAT(FindMarks(history.List("Ida")[0]), testing::ElementsAre("same recording or beginning as number 2"));
  const std::string page = FormatTeacherPage(rows, {{one.signer, "room 3"}});
  EXPECT_THAT(page, HasSubstr("3 of them are marked"));
  EXPECT_THAT(page, HasSubstr("signed by dddddddddddddddd (room 3)"));
  EXPECT_THAT(page, HasSubstr("same recording or beginning as number 2"));
  EXPECT_THAT(FormatTeacherPage(rows), HasSubstr("(an unknown key)"));
  // An attempt that is not graded is not a point of a curve.
  const auto circles = [](const std::string& html) {
    std::size_t count = 0;
    for (auto at = html.find("<circle"); at != std::string::npos; at = html.find("<circle", at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(circles(page), 2U);
}

TEST_F(HistoryTest, CopiesWithTheSameBeginningAreDuplicates) {
  History history(File());
  const auto add = [&](const char* hash, const char* steps, const char* beginning) {
    Attempt a = MakeOne("Ida", hash, 40);
    a.steps_digest = steps;
    a.beginning = beginning;
    EXPECT_TRUE(history.Add(a));
  };
  add("a", "all", "first");
  add("b", "less", "first");  // cut short
  add("c", "other", "other");
  add("d", "", "");  // of an earlier version
  add("e", "", "");
  const std::vector<Attempt> rows = history.List();
  EXPECT_EQ(rows[0].duplicates, std::vector<std::int64_t>{2});
  EXPECT_EQ(rows[1].duplicates, std::vector<std::int64_t>{1});
  for (std::size_t i = 2; i < 5; ++i) EXPECT_TRUE(rows[i].duplicates.empty()) << i;
}

// Formerly each attempt listed all of its doubles, and 8000 copies gave 376 MB of text.
TEST_F(HistoryTest, OnlyAFewOfManyDuplicatesAreNamed) {
  constexpr std::size_t kMany = 8000;
  std::vector<Attempt> attempts(kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    attempts[i].number = static_cast<std::int64_t>(i + 1);
    attempts[i].steps_digest = "same";
  }
  FindDuplicates(attempts);
  EXPECT_EQ(attempts[0].duplicates, (std::vector<std::int64_t>{2, 3, 4, 5, 6}));
  EXPECT_EQ(attempts[2].duplicates, (std::vector<std::int64_t>{1, 2, 4, 5, 6}));
  EXPECT_EQ(attempts[0].more_duplicates, kMany - 6);
  EXPECT_THAT(FindMarks(attempts[0]),
              testing::ElementsAre("same recording or beginning as number 2, 3, 4, 5, 6 and 7994 more"));
}

TEST_F(HistoryTest, ForeignTablesViewsAndTriggersAreRefused) {
  const std::string endless_view =
      "ALTER TABLE attempts RENAME TO a2; CREATE VIEW attempts AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT "
      "x + 1 FROM n) SELECT x AS number, '' AS student FROM n";
  const std::string trigger = "CREATE TRIGGER t AFTER INSERT ON attempts BEGIN DELETE FROM attempts; END";
  for (const std::string& change :
       {endless_view, trigger, std::string("CREATE TABLE more (x)"),
        std::string("CREATE INDEX by_total ON attempts (total)"),
        std::string("ALTER TABLE attempts ADD COLUMN more TEXT"), std::string("PRAGMA user_version = 1")}) {
    for (const char* with : {"-wal", "-shm", ""}) std::filesystem::remove(File() + with);
    History(File()).Add(MakeOne("Ida", "a", 1));
    EXPECT_EQ(MessageOfOpening(), "");
    Execute(change);
    EXPECT_THAT(MessageOfOpening(), HasSubstr("has tables, views or triggers that a history of kerf does not have"))
        << change;
  }
}

// Formerly, printing a nesting of 80,000 levels overflowed the stack, and a number in place of an object threw an
// exception.
TEST_F(HistoryTest, InvalidMeasuresAreLeftOut) {
  const std::string deep = R"({"measures":{"cut_share":)" + std::string(80'000, '[') + std::string(80'000, ']') + "}}";
  const std::string long_one = R"({"measures":{"cut_share":{"value":1}},"more":")" + std::string(2 << 20, 'x') + "\"}";
  for (const std::string& measures :
       {deep, long_one, std::string(R"({"measures":{"cut_share":5}})"), std::string(R"({"measures":[1]})"),
        std::string("[]"), std::string("{"), std::string(R"({"measures":{"cut_share":{"value":"x"}}})")}) {
    for (const bool damaged : {false, true}) {
      Attempt a = MakeOne("Ida", "a", 40);
      a.measures_json = measures;
      a.damaged = damaged;
      const auto json = nlohmann::json::parse(FormatHistoryJson({a}));
      EXPECT_EQ(json[0]["damaged"], damaged);
      EXPECT_FALSE(a.Get("cut_share")) << measures.substr(0, 60);
      EXPECT_THAT(FormatHistoryCsv({a}), HasSubstr(damaged ? ",a,,,,," : ",a,40.0000,,,,")) << measures.substr(0, 60);
      EXPECT_THAT(FormatTeacherPage({a}), HasSubstr("<td>-</td>"));
    }
  }
  // The same applies to a damaged row with a valid sheet.
  History(File()).Add(MakeOne("Ida", "a", 40));
  Execute("UPDATE attempts SET total = 99");
  const std::vector<Attempt> rows = History(File()).List();
  EXPECT_TRUE(nlohmann::json::parse(FormatHistoryJson(rows))[0]["measures"].empty());
  EXPECT_THAT(FormatHistoryCsv(rows), testing::AllOf(HasSubstr(",a,,,,,"), testing::Not(HasSubstr("99"))));
}

TEST_F(HistoryTest, TextsOfRowsCannotControlTheTerminal) {
  {
    History history(File());
    history.Add(MakeOne("Ida", "a", 40));
    history.Add(MakeOne("O\xc2\x9bl\xe2\x80\xae", "b", 40));  // through the library, and valid
  }
  Execute(
      "UPDATE attempts SET student = 'I' || char(27) || '[2J' || char(7) || char(10) || 'da', "
      "hash = 'a' || char(27), exercise = 'x' || char(155) WHERE number = 1");
  const std::vector<Attempt> rows = History(File()).List();
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_TRUE(rows[0].damaged);
  EXPECT_FALSE(rows[1].damaged);
  EXPECT_EQ(rows[0].student, "I?[2J??da");
  EXPECT_EQ(rows[1].student, "O?l?");
  for (const std::string& text : {FormatHistory(rows), FormatHistoryCsv(rows), FormatTeacherPage(rows)}) {
    EXPECT_EQ(text.find_first_of("\x1b\a\x7f"), std::string::npos);
    EXPECT_EQ(text.find("\xc2\x9b"), std::string::npos);
    EXPECT_EQ(text.find("\xe2\x80\xae"), std::string::npos);
  }
  EXPECT_EQ(History(File()).List("O\xc2\x9bl\xe2\x80\xae").size(), 2U);  // including the damaged one
}

TEST_F(HistoryTest, LocationFollowsTheEnvironment) {
  const char* was = std::getenv("KERF_DATA");
  const std::string kept = was == nullptr ? "" : was;
  setenv("KERF_DATA", "/somewhere", 1);
  EXPECT_EQ(FindHistoryFile(), "/somewhere/practise.db");
  unsetenv("KERF_DATA");
  setenv("XDG_DATA_HOME", "/data", 1);
  EXPECT_EQ(FindHistoryFile(), "/data/kerf/practise.db");
  unsetenv("XDG_DATA_HOME");
  setenv("HOME", "/nowhere/ida", 1);
  EXPECT_EQ(FindHistoryFile(), "/nowhere/ida/.local/share/kerf/practise.db");
  if (was != nullptr) setenv("KERF_DATA", kept.c_str(), 1);
}

TEST_F(HistoryTest, IsWrittenAsTableJsonCsvAndPage) {
  std::vector<Attempt> attempts{MakeOne("<i>Ida</i>", "a", 40), MakeOne("<i>Ida</i>", "b", 60),
                                MakeOne("Ole, \"Ol\"", "c", 80)};
  attempts[1].total.reset();
  const auto json = nlohmann::json::parse(FormatHistoryJson(attempts));
  ASSERT_EQ(json.size(), 3U);
  EXPECT_EQ(json[0]["measures"]["plane_offset_mm"]["value"], 0.25);
  EXPECT_TRUE(json[1]["total"].is_null());
  const std::string csv = FormatHistoryCsv(attempts);
  EXPECT_THAT(csv, HasSubstr("\"Ole, \"\"Ol\"\"\""));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_THAT(FormatHistoryCsv({MakeOne("=cmd|' /C calc'!A0", "d", 1)}), HasSubstr(",'=cmd|"));
  const std::string page = FormatTeacherPage(attempts);
  EXPECT_THAT(page, HasSubstr("&lt;i&gt;Ida"));
  EXPECT_THAT(page, testing::Not(HasSubstr("<i>Ida")));
  EXPECT_THAT(page, HasSubstr("attempt (number)"));
  EXPECT_THAT(page, HasSubstr("total (points out of 100)"));
  EXPECT_THAT(page, testing::Not(HasSubstr("http")));
  EXPECT_THAT(FormatHistory(attempts), HasSubstr("groove"));
}

TEST(TrimStudentName, RemovesSpacesAtBothEndsOnly) {
  EXPECT_EQ(TrimStudentName("  ann mller "), "ann mller");
  EXPECT_EQ(TrimStudentName("Ben"), "Ben");
  EXPECT_EQ(TrimStudentName("   "), "");
  EXPECT_EQ(TrimStudentName(""), "");
  EXPECT_NO_THROW(CheckStudentName(TrimStudentName(" Bea ")));
}

TEST(ListStudents, NamesEachStudentOnceTheLatestFirst) {
  std::vector<Attempt> attempts(5);
  const char* names[] = {"Ann", "Bo", "Ann", "?", "Cy"};
  for (std::size_t i = 0; i < attempts.size(); ++i) attempts[i].student = names[i];
  attempts[3].damaged = true;
  EXPECT_EQ(ListStudents(attempts), (std::vector<std::string>{"Cy", "Ann", "Bo"}));
  EXPECT_TRUE(ListStudents({}).empty());
}

TEST(FindSameStudent, NamesThatDifferOnlyInCapitalsAreTheSame) {
  std::vector<Attempt> attempts(3);
  attempts[0].student = "Mia Lee";
  attempts[1].student = "J\u00d6RG";
  attempts[2].student = "mia l\u00e8e";
  EXPECT_EQ(FindSameStudent(attempts, "mia lee"), "Mia Lee");
  EXPECT_EQ(FindSameStudent(attempts, "Mia Lee"), "Mia Lee");
  EXPECT_EQ(FindSameStudent(attempts, "J\u00f6rg"), "J\u00d6RG");
  EXPECT_EQ(FindSameStudent(attempts, "Mia Le"), "Mia Le");
  EXPECT_EQ(FindSameStudent({}, "Jo"), "Jo");
  // Two that exist already stay two.
  attempts[2].student = "mia lee";
  EXPECT_EQ(FindSameStudent(attempts, "mia lee"), "mia lee");
  EXPECT_EQ(FindSameStudent(attempts, "Mia Lee"), "Mia Lee");
}

}  // namespace
}  // namespace kerf
