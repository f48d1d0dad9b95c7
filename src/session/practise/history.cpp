#include "session/practise/history.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/core/errno_text.h"
#include "base/core/hash.h"
#include "base/core/printable.h"
#include "base/files/disk_space.h"
#include "base/files/files.h"
#include "base/files/user_folders.h"
#include "kerf/error.h"
#include "session/practise/exercises.h"
#include "session/practise/history_check.h"

namespace kerf {
namespace {

constexpr int kApplication = 0x6b657266;  // "kerf"
constexpr int kVersion = 2;
constexpr int kBusy_ms = 5000;
constexpr std::size_t kMaxName = 200;

struct CloseDatabase {
  void operator()(sqlite3* db) const { sqlite3_close(db); }
};
struct EndStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;
using Statement = std::unique_ptr<sqlite3_stmt, EndStatement>;

/// Returns true if a call failed because the disk is full, as far as SQLite or the system reports this.
bool IsDiskFull(const std::string& file, sqlite3* db, int code) {
  if ((code & 0xff) == SQLITE_FULL) return true;
  if ((code & 0xff) != SQLITE_IOERR && (code & 0xff) != SQLITE_CANTOPEN) return false;
  const int reason = db != nullptr ? sqlite3_system_errno(db) : 0;
  if (reason == ENOSPC || reason == EDQUOT) return true;
  // For the log's index, a file of 32 kB that is mapped as shared memory, SQLite does not store the system's error.
  constexpr double kIndexBytes = 32768;
  const int detail = db != nullptr ? sqlite3_extended_errcode(db) : code;
  const bool writes = detail == SQLITE_IOERR_WRITE || detail == SQLITE_IOERR_SHMSIZE || detail == SQLITE_IOERR_SHMMAP ||
                      detail == SQLITE_IOERR_SHMOPEN || detail == SQLITE_IOERR_FSYNC || detail == SQLITE_IOERR_TRUNCATE;
  return writes && ReadFreeDiskBytes(file) < kIndexBytes;
}

[[noreturn]] void Fail(const std::string& file, sqlite3* db, int code) {
  if (IsDiskFull(file, db, code)) throw Error(fmt::format("{}: can't be written: the disk is full", file));
  if (db != nullptr && sqlite3_system_errno(db) == EIO) {
    throw Error(fmt::format("{}: can't be read or written: {}", file, FormatErrno(EIO)));
  }
  switch (code & 0xff) {
    case SQLITE_NOTADB:
      throw Error(fmt::format("{}: is not a history of kerf; move it away, and kerf will create a new one", file));
    case SQLITE_CORRUPT:
      throw Error(fmt::format(
          "{}: the history is damaged; restore a copy of it, or move it away, and kerf will create a new one", file));
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Error(fmt::format("{}: another program has locked the history for more than {} s", file, kBusy_ms / 1000));
    default:
      throw Error(fmt::format("{}: the history can't be used: {}", file,
                              db != nullptr ? sqlite3_errmsg(db) : sqlite3_errstr(code)));
  }
}

void Do(const std::string& file, sqlite3* db, const char* sql) {
  const int code = sqlite3_exec(db, sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) Fail(file, db, code);
}

Statement Prepare(const std::string& file, sqlite3* db, const char* sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(db, sql, -1, &statement, nullptr);
  if (code != SQLITE_OK) Fail(file, db, code);
  return Statement(statement);
}

/// Sets the write-ahead-log mode. Retries explicitly, because SQLite ignores its busy timeout for this statement, so
/// that two waiting programs cannot deadlock. The program that holds the lock may set the mode instead. Writes are just
/// as safe before the mode is set.
void BeginLog(const std::string& file, sqlite3* db) {
  constexpr int kStep_ms = 10;
  int code = SQLITE_BUSY;
  for (int waited_ms = 0; (code & 0xff) == SQLITE_BUSY && waited_ms < kBusy_ms; waited_ms += kStep_ms) {
    if (waited_ms > 0) sqlite3_sleep(kStep_ms);
    code = sqlite3_exec(db, "PRAGMA journal_mode = WAL", nullptr, nullptr, nullptr);
  }
  if (code != SQLITE_OK && (code & 0xff) != SQLITE_BUSY) Fail(file, db, code);
}

int QueryNumber(const std::string& file, sqlite3* db, const char* sql) {
  const Statement statement = Prepare(file, db, sql);
  const int code = sqlite3_step(statement.get());
  if (code != SQLITE_ROW) Fail(file, db, code);
  return sqlite3_column_int(statement.get(), 0);
}

void Bind(const Statement& statement, int place, const std::string& text) {
  sqlite3_bind_text(statement.get(), place, text.c_str(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
}

/// All stored columns in order, from the row's number to the signer.
constexpr const char* kColumns =
    "number, student, exercise, level, taken, recording, hash, total, measures, state, incomplete, steps, "
    "beginning, seal, signer";
/// Index of the column after them in List().
constexpr int kSumColumn = 15;

std::string GetText(const Statement& statement, int column) {
  const unsigned char* text = sqlite3_column_text(statement.get(), column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement.get(), column));
  std::string copy(size, '\0');
  for (std::size_t i = 0; i < size; ++i) copy[i] = static_cast<char>(text[i]);
  return copy;
}

Attempt ReadRow(const Statement& row) {
  Attempt a;
  a.number = sqlite3_column_int64(row.get(), 0);
  a.student = GetText(row, 1);
  a.exercise = GetText(row, 2);
  a.level = sqlite3_column_int(row.get(), 3);
  a.taken = GetText(row, 4);
  a.recording = GetText(row, 5);
  a.hash = GetText(row, 6);
  if (sqlite3_column_type(row.get(), 7) != SQLITE_NULL) a.total = sqlite3_column_double(row.get(), 7);
  a.measures_json = GetText(row, 8);
  a.recording_state = GetText(row, 9);
  a.incomplete = GetText(row, 10);
  a.steps_digest = GetText(row, 11);
  a.beginning = GetText(row, 12);
  a.seal = GetText(row, 13);
  a.signer = GetText(row, 14);
  return a;
}

/// Removes text that could affect a terminal, and the measures of a changed row.
void Sanitize(Attempt& a) {
  for (std::string* text : {&a.student, &a.exercise, &a.taken, &a.recording, &a.hash, &a.recording_state, &a.incomplete,
                            &a.steps_digest, &a.beginning, &a.seal, &a.signer}) {
    *text = Printable(*text);
  }
  if (a.damaged) a.measures_json.clear();
}

/// Writes the row's checksum and the checksum of the chain up to this row.
void WriteSums(const std::string& file, sqlite3* db, std::int64_t number, const RowSums& sums) {
  const Statement statement = Prepare(file, db, "UPDATE attempts SET sum = ?1, chain = ?2 WHERE number = ?3");
  Bind(statement, 1, sums.own);
  Bind(statement, 2, sums.chain);
  sqlite3_bind_int64(statement.get(), 3, number);
  const int code = sqlite3_step(statement.get());
  if (code != SQLITE_DONE) Fail(file, db, code);
}

/// Makes the table of version 1.
void MakeTable(const std::string& file, sqlite3* db) {
  Do(file, db,
     "CREATE TABLE attempts (number INTEGER PRIMARY KEY, student TEXT NOT NULL, exercise TEXT NOT NULL, "
     "level INTEGER NOT NULL, taken TEXT NOT NULL, recording TEXT NOT NULL, hash TEXT NOT NULL, total REAL, "
     "measures TEXT NOT NULL, UNIQUE (student, hash))");
}

/// Adds the columns that are new in version 2.
void AddColumns(const std::string& file, sqlite3* db) {
  for (const char* column : {"state", "incomplete", "steps", "beginning", "seal", "signer", "sum", "chain"}) {
    Do(file, db, fmt::format("ALTER TABLE attempts ADD COLUMN {} TEXT NOT NULL DEFAULT ''", column).c_str());
  }
}

/// Returns the contents of sqlite_master for tables, indices, views and triggers, without spaces and without SQLite's
/// own statistics.
std::string DescribeSchema(const std::string& file, sqlite3* db) {
  const Statement statement =
      Prepare(file, db,
              "SELECT type || ' ' || name || ' ' || tbl_name || ' ' || coalesce(sql, '') FROM sqlite_master "
              "WHERE NOT (type = 'table' AND name LIKE 'sqlite_stat%') ORDER BY name");
  std::string schema;
  int code = sqlite3_step(statement.get());
  for (; code == SQLITE_ROW; code = sqlite3_step(statement.get())) schema += GetText(statement, 0) + ";";
  if (code != SQLITE_DONE) Fail(file, db, code);
  std::erase_if(schema, [](char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; });
  return schema;
}

/// Compares the schema with that of a new history. A view in place of the table could run forever, and a trigger could
/// write arbitrary data.
void CheckSchema(const std::string& file, sqlite3* db, int version) {
  sqlite3* made = nullptr;
  const int code = sqlite3_open(":memory:", &made);
  const Database memory(made);
  if (code != SQLITE_OK) Fail(file, made, code);
  MakeTable(file, made);
  if (version > 1) AddColumns(file, made);
  if (DescribeSchema(file, db) == DescribeSchema(file, made)) return;
  throw Error(
      fmt::format("{}: has tables, views or triggers that a history of kerf does not have; it is not used", file));
}

/// Converts version 1 to 2: the rows get checksums of their current values, and the new columns stay empty.
void ConvertFromVersion1(const std::string& file, sqlite3* db) {
  AddColumns(file, db);
  std::vector<Attempt> rows;
  {
    const Statement statement =
        Prepare(file, db, fmt::format("SELECT {} FROM attempts ORDER BY number", kColumns).c_str());
    int code = sqlite3_step(statement.get());
    for (; code == SQLITE_ROW; code = sqlite3_step(statement.get())) rows.push_back(ReadRow(statement));
    if (code != SQLITE_DONE) Fail(file, db, code);
  }
  std::string chain;
  for (const Attempt& row : rows) {
    const RowSums sums = CalcRowSums(row, chain);
    WriteSums(file, db, row.number, sums);
    chain = sums.chain;
  }
}

/// Checks the structure of the file; the contents of the rows are checked by means of their checksums.
void CheckStructure(const std::string& file, sqlite3* db) {
  const Statement statement = Prepare(file, db, "PRAGMA quick_check(1)");
  const int code = sqlite3_step(statement.get());
  if (code != SQLITE_ROW) Fail(file, db, code);
  if (GetText(statement, 0) != "ok") Fail(file, db, SQLITE_CORRUPT);
}

/// Returns UTF-8 text with the capital letters of ASCII and Latin-1 as small ones.
std::string FoldCase(std::string text) {
  constexpr char kLatin1 = '\xc3';  // first byte of U+00C0 to U+00FF; capitals are 0x80 to 0x9e, 0x97 is a sign
  char last = 0;
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (last == kLatin1 && byte >= 0x80 && byte <= 0x9e && byte != 0x97) c = static_cast<char>(byte + 0x20);
    last = c;
  }
  return text;
}

}  // namespace

struct History::State {
  std::string file;
  Database db;
};

std::optional<double> Attempt::Get(const std::string& key) const {
  return FindValue(ParseMeasures(*this), key);
}

std::string FindHistoryFile() {
  if (const std::string folder = GetVariable("KERF_DATA"); !folder.empty()) return folder + "/practise.db";
  if (const std::string data = FindUserFolder(UserFolder::kData); !data.empty()) return data + "/kerf/practise.db";
  throw Error("there is no folder for the history: set KERF_DATA to one");
}

History::History(const std::string& file) : state_(std::make_unique<State>()) {
  state_->file = file;
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  if (!folder.empty()) MakeFolder(folder.string());
  sqlite3* db = nullptr;
  const int code = sqlite3_open_v2(file.c_str(), &db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  state_->db.reset(db);
  if (code != SQLITE_OK) Fail(file, db, code);
  sqlite3_busy_timeout(db, kBusy_ms);
  sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  // Two programs may create the same history at the same time: the second finds the result of the first.
  Do(file, db, "BEGIN IMMEDIATE");
  const int application = QueryNumber(file, db, "PRAGMA application_id");
  const int version = QueryNumber(file, db, "PRAGMA user_version");
  if (application != kApplication && QueryNumber(file, db, "SELECT count(*) FROM sqlite_master") > 0) {
    throw Error(fmt::format("{}: is a database of another program, not a history of kerf", file));
  }
  if (version > kVersion) {
    throw Error(fmt::format("{}: the history was written by a later version of kerf (format {}, this one supports {})",
                            file, version, kVersion));
  }
  if (version < 1) {
    MakeTable(file, db);
    Do(file, db, fmt::format("PRAGMA application_id = {}", kApplication).c_str());
  }
  CheckSchema(file, db, std::max(version, 1));
  CheckStructure(file, db);
  if (version < kVersion) {
    ConvertFromVersion1(file, db);
    Do(file, db, fmt::format("PRAGMA user_version = {}", kVersion).c_str());
  }
  Do(file, db, "COMMIT");
  // Readers do not wait for a writer, and a killed program leaves the earlier contents intact.
  BeginLog(file, db);
}

History::~History() = default;
History::History(History&&) noexcept = default;
History& History::operator=(History&&) noexcept = default;

const std::string& History::file() const {
  return state_->file;
}

bool History::Add(const Attempt& attempt) {
  sqlite3* db = state_->db.get();
  const std::string& file = state_->file;
  // The chain continues from the last row, which must remain the last until this one is added.
  Do(file, db, "BEGIN IMMEDIATE");
  try {
    const bool is_new = Insert(attempt);
    Do(file, db, "COMMIT");
    return is_new;
  } catch (const Error&) {
    sqlite3_exec(db, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

bool History::Insert(const Attempt& attempt) {
  sqlite3* db = state_->db.get();
  const std::string& file = state_->file;
  std::string chain;
  {
    const Statement last = Prepare(file, db, "SELECT chain FROM attempts ORDER BY number DESC LIMIT 1");
    if (sqlite3_step(last.get()) == SQLITE_ROW) chain = GetText(last, 0);
  }
  const Statement statement =
      Prepare(file, db,
              "INSERT OR IGNORE INTO attempts (student, exercise, level, taken, recording, hash, total, measures, "
              "state, incomplete, steps, beginning, seal, signer) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  Bind(statement, 1, attempt.student);
  Bind(statement, 2, attempt.exercise);
  sqlite3_bind_int(statement.get(), 3, attempt.level);
  Bind(statement, 4, attempt.taken);
  Bind(statement, 5, attempt.recording);
  Bind(statement, 6, attempt.hash);
  if (attempt.total) sqlite3_bind_double(statement.get(), 7, *attempt.total);
  Bind(statement, 8, attempt.measures_json);
  Bind(statement, 9, attempt.recording_state);
  Bind(statement, 10, attempt.incomplete);
  Bind(statement, 11, attempt.steps_digest);
  Bind(statement, 12, attempt.beginning);
  Bind(statement, 13, attempt.seal);
  Bind(statement, 14, attempt.signer);
  const int code = sqlite3_step(statement.get());
  if (code != SQLITE_DONE) Fail(file, db, code);
  if (sqlite3_changes(db) == 0) return false;
  Attempt row = attempt;
  row.number = sqlite3_last_insert_rowid(db);
  WriteSums(file, db, row.number, CalcRowSums(row, chain));
  return true;
}

std::vector<Attempt> History::List(const std::string& student) const {
  sqlite3* db = state_->db.get();
  const Statement statement =
      Prepare(state_->file, db, fmt::format("SELECT {}, sum, chain FROM attempts ORDER BY number", kColumns).c_str());
  std::vector<Attempt> attempts;
  std::vector<bool> is_listed;
  std::string chain;
  int code = sqlite3_step(statement.get());
  for (; code == SQLITE_ROW; code = sqlite3_step(statement.get())) {
    Attempt a = ReadRow(statement);
    const std::string sum = GetText(statement, kSumColumn);
    const RowSums sums = CalcRowSums(a, chain);
    a.damaged = sum != sums.own;
    chain = GetText(statement, kSumColumn + 1);
    a.follows_change = !a.damaged && chain != sums.chain;
    is_listed.push_back(student.empty() || a.student == student || a.damaged);
    Sanitize(a);
    attempts.push_back(std::move(a));
  }
  if (code != SQLITE_DONE) Fail(state_->file, db, code);
  FindDuplicates(attempts);
  std::vector<Attempt> listed;
  for (std::size_t i = 0; i < attempts.size(); ++i) {
    if (is_listed[i]) listed.push_back(std::move(attempts[i]));
  }
  return listed;
}

std::string FindSameStudent(const std::vector<Attempt>& attempts, const std::string& student) {
  const std::string wanted = FoldCase(student);
  const std::string* found = &student;
  for (const Attempt& a : attempts) {
    if (a.damaged) continue;
    if (a.student == student) return student;
    if (FoldCase(a.student) == wanted) found = &a.student;
  }
  return *found;
}

std::vector<std::string> ListStudents(const std::vector<Attempt>& attempts) {
  std::vector<std::string> students;
  for (auto a = attempts.rbegin(); a != attempts.rend(); ++a) {
    if (a->damaged || std::find(students.begin(), students.end(), a->student) != students.end()) continue;
    students.push_back(a->student);
  }
  return students;
}

std::string TrimStudentName(const std::string& entered) {
  const std::size_t first = entered.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return entered.substr(first, entered.find_last_not_of(' ') - first + 1);
}

void CheckStudentName(const std::string& student) {
  if (student.empty()) throw Error("the student has no name");
  if (student.front() == ' ' || student.back() == ' ') throw Error("the student's name begins or ends with a space");
  if (Printable(student) != student) throw Error("the student's name contains control characters, or is not UTF-8");
  if (student.size() > kMaxName) throw Error(fmt::format("the student's name is longer than {} bytes", kMaxName));
}

Attempt MakeAttempt(const ScoreSheet& sheet, const std::string& student) {
  CheckStudentName(student);
  Attempt attempt;
  attempt.student = student;
  const Exercise* exercise = FindExerciseOf(sheet.scene);
  attempt.exercise = exercise != nullptr ? exercise->id : sheet.scene;
  attempt.level = sheet.level;
  attempt.taken = sheet.created;
  attempt.recording = std::filesystem::absolute(sheet.recording).lexically_normal().string();
  std::uint64_t hash = 0;
  for (const char c : ReadTextFile(sheet.recording, kMaxRecordingBytes)) {
    hash = MixHash(hash ^ static_cast<unsigned char>(c));
  }
  attempt.hash = fmt::format("{:016x}", hash);
  attempt.total = sheet.total;
  attempt.measures_json = FormatSheetJson(sheet);
  attempt.recording_state = ToString(sheet.state);
  attempt.incomplete = fmt::format("{}", fmt::join(sheet.incomplete, "; "));
  attempt.steps_digest = sheet.steps_digest;
  attempt.beginning = sheet.beginning_digest;
  attempt.seal = DescribeChain(sheet.seal);
  attempt.signer = sheet.seal.signer;
  return attempt;
}

}  // namespace kerf
