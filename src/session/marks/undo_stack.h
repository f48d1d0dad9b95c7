// Undo and redo of a small value, such as a plan or the user's marks: each step keeps a copy.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace kerf {

/// Value: any copyable type. Steps older than the limit are forgotten.
template <typename Value>
class UndoStack {
 public:
  explicit UndoStack(Value initial = {}, std::size_t max_steps = 200) : max_steps_(max_steps) {
    steps_.push_back({std::move(initial), ""});
  }

  const Value& now() const { return steps_[at_].value; }
  /// Makes `next` the current value, as a new step named `what`; what could be redone is forgotten.
  void Push(Value next, std::string what) {
    steps_.resize(at_ + 1);
    steps_.push_back({std::move(next), std::move(what)});
    if (steps_.size() > max_steps_ + 1) steps_.erase(steps_.begin());
    at_ = steps_.size() - 1;
  }
  /// Replaces the value of the current step, for a gesture that changes it many times. Without any step so far, it
  /// replaces the initial value.
  void Amend(Value next) {
    steps_.resize(at_ + 1);
    steps_[at_].value = std::move(next);
  }
  bool can_undo() const { return at_ > 0; }
  bool can_redo() const { return at_ + 1 < steps_.size(); }
  /// Name of the step that Undo() or Redo() affects; empty if there is none.
  std::string undo_name() const { return can_undo() ? steps_[at_].what : ""; }
  std::string redo_name() const { return can_redo() ? steps_[at_ + 1].what : ""; }
  /// Return false if there is nothing to undo or redo.
  bool Undo() {
    if (!can_undo()) return false;
    --at_;
    return true;
  }
  bool Redo() {
    if (!can_redo()) return false;
    ++at_;
    return true;
  }

 private:
  struct Step {
    Value value;
    std::string what;
  };
  std::vector<Step> steps_;
  std::size_t at_ = 0;
  std::size_t max_steps_;
};

}  // namespace kerf
