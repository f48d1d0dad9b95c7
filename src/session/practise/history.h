// Who practised what, when, and how well: kept in a database in the user's data folder.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "loop/record/seal.h"
#include "session/score/measures.h"

namespace kerf {

struct Attempt {
  std::int64_t number = 0;  // given by the history
  std::string student;
  std::string exercise;  // its id, or the scene's name
  int level = 0;
  std::string taken;      // UTC, as the recording has it
  std::string recording;  // its file when it was handed in
  std::string hash;       // of that file's bytes
  std::optional<double> total;
  std::string measures_json;  // FormatSheetJson()
  // Empty in attempts that an earlier version of kerf kept.
  std::string recording_state;  // ToString(RecordingState)
  std::string incomplete;       // why it is not graded, phrases with "; " between; empty: it is complete
  std::string steps_digest;     // of what the ticks were given: the same in copies of a recording
  std::string beginning;        // a digest of the first of them: the same in copies that end earlier or go on otherwise
  std::string seal;             // DescribeChain()
  PublicKey signer;             // whose signature is good; empty: none

  // What List() finds; not kept.
  bool damaged = false;         // the row is not what Add() wrote: nothing in it can be relied on
  bool follows_change = false;  // one or more rows before it were changed, removed or added
  // Attempts of the same recording or beginning, of this student or another: the first few, and how many more.
  std::vector<std::int64_t> doubles{};
  std::size_t more_doubles = 0;

  /// Has a total that counts.
  bool graded() const { return total && !damaged && incomplete.empty(); }
  /// Of measures_json; none where it has none, or is no sheet.
  std::optional<double> Get(const std::string& key) const;
};

/// $KERF_DATA/practise.db; else that in kerf of $XDG_DATA_HOME; else ~/.local/share/kerf/practise.db. Throws Error
/// when none of the three is set.
std::string FindHistoryFile();

class History {
 public:
  /// Makes file and folder when they are missing, and brings a history of an earlier kerf up to this one's form, all of
  /// it or nothing. Throws Error with one sentence for a file that is no history, holds other tables, views or triggers
  /// than those of kerf, is damaged in its structure, or was written by a later kerf, and where it can't be written.
  explicit History(const std::string& file);
  ~History();
  History(History&&) noexcept;
  History& operator=(History&&) noexcept;

  /// False, and nothing done, when the student has handed in the same recording before. Several programs may add at the
  /// same time. Throws Error.
  bool Add(const Attempt& attempt);
  /// In the order in which they were handed in; of one student, or of all when `student` is empty. Each row is held
  /// against its checksum and all of them against their chain, and attempts of all students are looked at for doubles.
  /// A damaged row is in every list, as its name may be what is damaged; its measures are left out. Control characters
  /// in texts become '?'. Throws Error.
  std::vector<Attempt> List(const std::string& student = "") const;
  const std::string& file() const;

 private:
  struct State;
  bool Insert(const Attempt& attempt);

  std::unique_ptr<State> state_;
};

/// Throws Error when it can't be a student's name: it is empty, too long, not UTF-8, or has control characters in it or
/// spaces at an end.
void CheckStudentName(const std::string& student);

/// A sheet as an attempt of that student. Throws Error when the name can't be one, or the recording can't be read.
Attempt MakeAttempt(const ScoreSheet& sheet, const std::string& student);

/// What is to be known of an attempt before its total is believed, a phrase each.
std::vector<std::string> FindMarks(const Attempt& attempt);

/// For people / with stable keys / as rows.
std::string FormatHistory(const std::vector<Attempt>& attempts);
std::string FormatHistoryJson(const std::vector<Attempt>& attempts);
std::string FormatHistoryCsv(const std::vector<Attempt>& attempts);
/// For the teacher: a self-contained page with the students' curves and all attempts, those that are not as they should
/// be marked. `known`: whose keys are known by name.
std::string FormatTeacherPage(const std::vector<Attempt>& attempts, const std::vector<KnownKey>& known = {});

}  // namespace kerf
