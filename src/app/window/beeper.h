// Plays the window's sound on the audio device.
#pragma once

#include <memory>
#include <optional>

#include "app/window/sound_generator.h"

namespace kerf {

/// Sound of the window: alarms by distance and the tone of the saw. A separate thread plays it. Nothing waits for that
/// thread, and least of all the loop.
class Beeper {
 public:
  /// Without an audio device no sound is played and has_sound() returns false.
  Beeper();
  ~Beeper();
  Beeper(const Beeper&) = delete;
  Beeper& operator=(const Beeper&) = delete;

  bool has_sound() const;
  /// Sets the distance that an alarm indicates, mm, negative beyond its goal; nullopt: silence. This function and the
  /// following ones may be called by any thread.
  void SetAlarm(AlarmKind kind, std::optional<double> distance_mm);
  /// Sets what the saw is heard doing: its spindle speed and the force on it. 0 rpm: silence.
  void SetSaw(double rpm, double force_N);
  /// Sets the volume, 0 to 100 %; other values are clamped.
  void SetVolume(double percent);
  void SetMuted(bool muted);
  double volume_percent() const;
  bool muted() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
