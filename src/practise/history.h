// Who practised what, when, and how well: kept in a database in the user's data folder.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "score/measures.h"

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

  /// Of measures_json; none where it has none.
  std::optional<double> Get(const std::string& key) const;
};

/// $KERF_DATA/practise.db; else that in kerf of $XDG_DATA_HOME; else ~/.local/share/kerf/practise.db. Throws Error
/// when none of the three is set.
std::string FindHistoryFile();

class History {
 public:
  /// Makes file and folder when they are missing. Throws Error with one sentence for a file that is no history, is
  /// damaged, or was written by a later kerf, and where it can't be written.
  explicit History(const std::string& file);
  ~History();
  History(History&&) noexcept;
  History& operator=(History&&) noexcept;

  /// False, and nothing done, when the student has handed in the same recording before. Several programs may add at the
  /// same time. Throws Error.
  bool Add(const Attempt& attempt);
  /// In the order in which they were handed in; of one student, or of all when `student` is empty. Throws Error.
  std::vector<Attempt> List(const std::string& student = "") const;
  const std::string& file() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A sheet as an attempt of that student. Throws Error when the name is empty or too long, or the recording can't be
/// read.
Attempt MakeAttempt(const ScoreSheet& sheet, const std::string& student);

/// For people / with stable keys / as rows.
std::string FormatHistory(const std::vector<Attempt>& attempts);
std::string FormatHistoryJson(const std::vector<Attempt>& attempts);
std::string FormatHistoryCsv(const std::vector<Attempt>& attempts);
/// For the teacher: a self-contained page with the students' curves and all attempts.
std::string FormatTeacherPage(const std::vector<Attempt>& attempts);

}  // namespace kerf
