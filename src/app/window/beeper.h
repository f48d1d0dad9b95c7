// A tone that tells how far it is to the goal, as cars tell it of a wall: beeps, quicker the nearer, one tone there, a
// high one beyond.
#pragma once

#include <memory>
#include <optional>

namespace kerf {

class Beeper {
 public:
  /// A machine without sound gives none: has_sound().
  Beeper();
  ~Beeper();
  Beeper(const Beeper&) = delete;
  Beeper& operator=(const Beeper&) = delete;

  bool has_sound() const;
  /// None: silence. Any thread.
  void Set(std::optional<double> to_goal_mm);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What is to be heard: so many beeps a second (0: none; infinite: one tone), of so many Hz.
struct Beep {
  double per_s = 0;
  double pitch_Hz = 0;
};
Beep CalcBeep(std::optional<double> to_goal_mm);

}  // namespace kerf
