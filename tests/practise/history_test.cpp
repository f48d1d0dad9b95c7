// The students' history, and what may be wrong with its file.
#include "practise/history.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "files/files.h"
#include "kerf/error.h"
#include "support/result_folder.h"

namespace kerf {
namespace {

using testing::HasSubstr;

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
    try {
      const History history(File());
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }
  void Execute(const char* sql) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(File().c_str(), &db), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
  }
};

TEST_F(HistoryTest, KeepsWhatItIsGiven) {
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

TEST_F(HistoryTest, IsOpenedWhileAnotherWritesNowAndThen) {
  History(File()).Add(MakeOne("a", "x", 1));
  for (int i = 0; i < 20; ++i) {
    Execute("PRAGMA journal_mode = DELETE");  // as before the first who opened it was done
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

TEST_F(HistoryTest, SaysInOneSentenceWhatIsWrongWithItsFile) {
  MakeFolder(folder_ + "/data");
  WriteTextFile(File(), std::string(4096, 'x'));
  EXPECT_THAT(MessageOfOpening(), HasSubstr("is no history of kerf"));
  std::filesystem::remove(File());
  Execute("CREATE TABLE cats (name TEXT)");
  EXPECT_THAT(MessageOfOpening(), HasSubstr("of another program"));
  std::filesystem::remove(File());
  History(File()).Add(MakeOne("Ida", "a", 1));
  Execute("PRAGMA user_version = 7");
  EXPECT_THAT(MessageOfOpening(), HasSubstr("later kerf"));
  Execute("PRAGMA user_version = 1");
  EXPECT_EQ(History(File()).List().size(), 1U);
  // Cut short, as by a full disk.
  std::filesystem::resize_file(File(), 1000);
  std::filesystem::remove(File() + "-wal");
  EXPECT_NE(MessageOfOpening(), "");
  EXPECT_EQ(MessageOfOpening().find('\n'), std::string::npos);
}

TEST_F(HistoryTest, IsWhereTheEnvironmentSays) {
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
  const std::string page = FormatTeacherPage(attempts);
  EXPECT_THAT(page, HasSubstr("&lt;i&gt;Ida"));
  EXPECT_THAT(page, testing::Not(HasSubstr("<i>Ida")));
  EXPECT_THAT(page, HasSubstr("attempt (number)"));
  EXPECT_THAT(page, HasSubstr("total (points of 100)"));
  EXPECT_THAT(page, testing::Not(HasSubstr("http")));
  EXPECT_THAT(FormatHistory(attempts), HasSubstr("groove"));
}

}  // namespace
}  // namespace kerf
