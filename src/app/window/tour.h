// Tour of the window for users who see it for the first time: some steps that can be skipped.
#pragma once

#include <string>
#include <vector>

#include "view/ui/event.h"
#include "view/ui/ui.h"

namespace kerf {

struct TourStep {
  std::string title;
  std::string text;
};

/// A box in a corner of the scene, in front of the list of exercises. It does not block the window, so that each step
/// can be tried at once, and covers no button.
class Tour {
 public:
  void Start(std::vector<TourStep> steps) {
    steps_ = std::move(steps);
    step_ = 0;
  }
  /// Replaces the texts by the same steps in another language.
  void SetSteps(std::vector<TourStep> steps) {
    if (is_open() && steps.size() == steps_.size()) steps_ = std::move(steps);
  }
  void GoOn() { ++step_; }
  void End() { step_ = steps_.size(); }
  bool is_open() const { return step_ < steps_.size(); }
  /// Number of the current step, from 1; 0: closed.
  int step() const { return is_open() ? static_cast<int>(step_) + 1 : 0; }
  /// Escape skips the tour. Returns true if the event was for the tour.
  bool Take(const WindowEvent& event);
  /// `in_front`: before all other panels; false if a dialog asks something.
  void Draw(Ui& ui, const UiBox& scene, bool in_front);

 private:
  std::vector<TourStep> steps_;
  std::size_t step_ = 0;
};

}  // namespace kerf
