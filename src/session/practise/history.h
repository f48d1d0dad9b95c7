// History of all attempts: student, exercise, time and score, in a database in the user's data folder.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/table/table.h"
#include "loop/record/seal.h"
#include "session/score/measures.h"

namespace kerf {

struct Attempt {
  std::int64_t number = 0;  // set by the history
  std::string student;
  std::string exercise;  // its id, or the scene's name
  int level = 0;
  std::string taken;      // UTC, from the recording
  std::string recording;  // path of its file when it was submitted
  std::string hash;       // hash of that file's bytes
  std::optional<double> total;
  std::string measures_json;  // FormatSheetJson()
  // Empty in attempts that an earlier version of kerf stored.
  std::string recording_state;  // ToString(RecordingState)
  std::string incomplete;       // reasons why it is not graded, separated by "; "; empty: complete
  std::string steps_digest;     // digest of the inputs of the ticks: the same in copies of a recording
  std::string beginning;  // digest of the first inputs: the same in copies that end earlier or continue differently
  std::string seal;       // DescribeChain()
  PublicKey signer;       // key of the valid signature; empty: none

  // Results of List(); not stored.
  bool damaged = false;         // the row is not as Add() wrote it: none of its values is reliable
  bool follows_change = false;  // one or more rows before it were changed, removed or added
  // Attempts with the same recording or beginning, of any student: the numbers of the first few, and how many more
  // there are.
  std::vector<std::int64_t> duplicates{};
  std::size_t more_duplicates = 0;

  /// Returns true if the attempt has a valid total.
  bool graded() const { return total && !damaged && incomplete.empty(); }
  /// Returns a value of measures_json; none if that lacks the key or is not a sheet.
  std::optional<double> Get(const std::string& key) const;
};

/// Returns $KERF_DATA/practise.db, otherwise kerf/practise.db in $XDG_DATA_HOME, otherwise
/// ~/.local/share/kerf/practise.db. Throws kerf::Error if none of the three is set.
std::string FindHistoryFile();

class History {
 public:
  /// Creates the file and its folder if they are missing. Converts a history that an earlier version of kerf wrote to
  /// the current form, completely or not at all. Throws kerf::Error for a file that is not a history, contains tables,
  /// views or triggers other than those of kerf, has a damaged structure or was written by a later version of kerf, and
  /// if the file cannot be written.
  explicit History(const std::string& file);
  ~History();
  History(History&&) noexcept;
  History& operator=(History&&) noexcept;

  /// Returns false, without effect, if the student has submitted the same recording before. Several programs may add
  /// attempts at the same time. Throws kerf::Error.
  bool Add(const Attempt& attempt);
  /// Returns the attempts in the order of submission; of one student, or of all if `student` is empty. Checks each row
  /// against its checksum and all rows against their chain, and searches the attempts of all students for duplicates. A
  /// damaged row is in every list, because its name may be damaged; its measures are left out. Control characters in
  /// texts become '?'. Throws kerf::Error.
  std::vector<Attempt> List(const std::string& student = "") const;
  const std::string& file() const;

 private:
  struct State;
  bool Insert(const Attempt& attempt);

  std::unique_ptr<State> state_;
};

/// Returns a name as it was entered, without spaces at its ends.
std::string TrimStudentName(const std::string& entered);
/// Throws kerf::Error if `student` is not a valid name: empty, too long, not UTF-8, with control characters, or with
/// leading or trailing spaces.
void CheckStudentName(const std::string& student);

/// Returns the name under which attempts of the student are stored: the name itself if it occurs in `attempts`, and
/// otherwise the latest one that differs from it only in capital letters (of ASCII and Latin-1), if there is any.
std::string FindSameStudent(const std::vector<Attempt>& attempts, const std::string& student);

/// Returns the names of all students with attempts, the one with the latest attempt first.
std::vector<std::string> ListStudents(const std::vector<Attempt>& attempts);

/// Returns a sheet as an attempt of the student. Throws kerf::Error if the name is invalid or the recording cannot be
/// read.
Attempt MakeAttempt(const ScoreSheet& sheet, const std::string& student);

/// Returns the reasons to doubt an attempt's total, one phrase for each.
std::vector<std::string> FindMarks(const Attempt& attempt);

/// A row of the CSV.
struct AttemptRow {
  const Attempt& attempt;
  std::vector<std::optional<double>> measures;  // in the order of Measures()
};
const Columns<AttemptRow>& HistoryColumns();
/// These format the attempts as readable text, as JSON with stable keys and as CSV with one row each.
std::string FormatHistory(const std::vector<Attempt>& attempts);
std::string FormatHistoryJson(const std::vector<Attempt>& attempts);
std::string FormatHistoryCsv(const std::vector<Attempt>& attempts);
/// Returns a self-contained page for the teacher with the students' curves and all attempts; attempts with faults are
/// marked. `known`: public keys whose owners are known.
std::string FormatTeacherPage(const std::vector<Attempt>& attempts, const std::vector<KnownKey>& known = {});

}  // namespace kerf
