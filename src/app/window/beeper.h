// Sound that indicates the distance to the goal, as parking sensors do: beeps that become faster towards the goal, a
// continuous tone at the goal, and a high one beyond it.
#pragma once

#include <memory>
#include <optional>

namespace kerf {

class Beeper {
 public:
  /// Without an audio device no sound is played and has_sound() returns false.
  Beeper();
  ~Beeper();
  Beeper(const Beeper&) = delete;
  Beeper& operator=(const Beeper&) = delete;

  /// Sets the distance to indicate; nullopt: silence. May be called by any thread.
  void Set(std::optional<double> to_goal_mm);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Sound to play: beeps per second (0: none; infinite: continuous tone) and their frequency in Hz.
struct Beep {
  double per_s = 0;
  double pitch_Hz = 0;
};
Beep CalcBeep(std::optional<double> to_goal_mm);

}  // namespace kerf
