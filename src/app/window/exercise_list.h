// The list of exercises of `kerf practise`, and the levels of each.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "session/practise/progress.h"
#include "view/ui/event.h"
#include "view/ui/ui.h"

namespace kerf {

/// Dialog with the exercises and, once one is chosen, with its levels. Controlled with Up, Down, Enter, Escape, the
/// digits and the mouse. At first, the recommended exercise and level are selected.
class ExerciseList {
 public:
  enum class Choice {
    kNone,
    kStart,  // exercise() at level()
    kName,   // the student wants to enter a name
  };
  /// `rows`: as made by ListProgress(), not empty. `student`: whose attempts are stored; empty: they are not stored.
  /// `next`: what is recommended.
  ExerciseList(std::vector<ExerciseRow> rows, std::string student, NextStep next);

  /// Takes a pressed key.
  Choice Take(const WindowEvent& event);
  Choice Draw(Ui& ui);
  const std::string& exercise() const { return rows_[row_].id; }
  int level() const { return level_; }
  /// Returns the title of what is shown: the list, or an exercise.
  std::string title() const;

 private:
  void OpenLevels(std::size_t row);
  int FindRecommendedLevel(const ExerciseRow& row) const;
  Choice DrawExercises(Ui& ui);
  Choice DrawLevels(Ui& ui);

  std::vector<ExerciseRow> rows_;
  std::string student_;
  NextStep next_;
  std::size_t row_ = 0;
  int level_ = 1;
  bool shows_levels_ = false;
  bool scrolls_ = true;     // to the selected row, in the next frame
  UiBox drawn_in_;          // size of the window in points of text, when it was drawn last
  int resized_frames_ = 0;  // until the rows have their new places
};

}  // namespace kerf
