// Tour of the window for users who see it for the first time: some steps that can be skipped.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "view/ui/event.h"
#include "view/ui/picture_marks.h"
#include "view/ui/ui.h"

namespace kerf {

struct TourStep {
  std::string title;
  std::string text;
  std::string action = {};  // name of what ends the step, for Tour::EndStep(); empty: only its button
  bool has_button = true;   // false: only the action leads to the next step
};

/// Returns the place of a box in a corner of the scene, also below a card at its top or beside the cube: the first
/// place in which it covers none of `buttons` and `others`, or that in which it covers the least, of the buttons first.
UiBox PlaceTour(const UiSize& size, const UiBox& scene, const UiBox& cube, const std::vector<UiBox>& buttons,
                const std::vector<UiBox>& others, double scale);

/// A box in a corner of the scene, in front of the list of exercises. It does not block the window, so that each step
/// can be tried at once, and covers no button.
class Tour {
 public:
  void Start(std::vector<TourStep> steps) {
    steps_ = std::move(steps);
    step_ = 0;
  }
  /// Replaces the texts by the same steps in another language. The first ones may be missing, if they are over.
  void SetSteps(const std::vector<TourStep>& steps) {
    const auto count = static_cast<std::ptrdiff_t>(std::min(steps.size(), steps_.size()));
    std::copy(steps.end() - count, steps.end(), steps_.end() - count);
  }
  /// Goes on if the current step is the one that this action ends.
  void EndStep(const std::string& action) {
    if (is_open() && steps_[step_].action == action) ++step_;
  }
  bool is_open() const { return step_ < steps_.size(); }
  /// Number of the current step, from 1; 0: closed.
  int step() const { return is_open() ? static_cast<int>(step_) + 1 : 0; }
  /// Escape skips the tour. Returns true if the event was for the tour.
  bool Take(const WindowEvent& event);
  /// `others`: what it should not cover in the scene, besides what a list or a card of an exercise contains.
  /// `in_front`: before all other panels.
  void Draw(Ui& ui, const UiBox& scene, const UiBox& cube, std::vector<UiBox> others, bool in_front);

 private:
  std::vector<TourStep> steps_;
  std::size_t step_ = 0;
};

}  // namespace kerf
