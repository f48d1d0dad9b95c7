// Samples of the window's sound: alarms by distance, as parking sensors give, and the tone of the saw.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace kerf {

/// What an alarm warns of. Each kind has its own pitch and range.
enum class AlarmKind : std::uint8_t {
  kDepth,      // the goal or limit of the depth
  kStructure,  // the nerve or another structure to be spared
  kMargin,     // the edge of the planned cut
};
inline constexpr std::size_t kAlarmKinds = 3;

/// Sound to play: beeps per second (0: none; infinite: continuous tone) and their frequency in Hz.
struct Beep {
  double per_s = 0;
  double pitch_Hz = 0;
};
/// Returns the alarm at a distance: none beyond the range of its kind, beeps that become faster towards 0.2 mm, a
/// continuous tone there, and a higher one beyond. nullopt and NaN: no sound.
Beep CalcAlarm(AlarmKind kind, std::optional<double> distance_mm);

/// Tone of a turning saw: its frequency and its loudness as a fraction of the largest.
struct SawTone {
  double frequency_Hz = 0;
  double level = 0;
};
/// Returns the tone at a spindle speed, in either direction, and a force on the saw: a higher speed gives a higher
/// tone; a load makes it louder and, as the motor slows down under it, a little lower.
SawTone CalcSawTone(double rpm, double force_N);

/// What is to be heard.
struct SoundState {
  std::array<std::optional<double>, kAlarmKinds> alarms_mm;  // distances, by AlarmKind
  double rpm = 0;
  double force_N = 0;
  double volume = 0.5;  // 0 to 1
  bool muted = false;
};

/// Generates the samples. Phases, frequencies and amplitudes are continuous, whatever the states are, so that nothing
/// clicks. When the sound is muted, the samples reach exactly zero within kFade_s.
class SoundGenerator {
 public:
  static constexpr unsigned kRate_Hz = 48'000;
  static constexpr double kFade_s = 0.01;
  static constexpr int kPeak = 32'000;  // no sample is larger

  /// Fills `samples` with the sound of a state that lasts during all of them.
  void Fill(const SoundState& state, std::span<std::int16_t> samples);

 private:
  struct Voice {
    double phase = 0;     // of the tone, cycles
    double beat = 0;      // of the beeps, cycles
    double level = 0;     // current loudness
    double pitch_Hz = 0;  // of the last beep
  };
  std::array<Voice, kAlarmKinds> voices_;
  double saw_phase_ = 0;
  double saw_Hz_ = 0;
  double saw_level_ = 0;
  double gain_ = 0;
};

}  // namespace kerf
