// Measures that distinguish a steady force from one that chatters, oscillates or changes without a cause. They work on
// signals sampled every dt_s. C1 to C9 are their names in docs/stability.md.
//
// All of them return NaN, which satisfies no bound, for a signal that is too short or has a value that is not finite.
// For a constant signal they return the best possible value. They throw Error if dt_s is not above 0 or a frequency,
// mass or fraction is out of range.
#pragma once

#include <span>

#include "kerf/geometry.h"

namespace kerf {

/// C1: root mean square above 20 Hz, all three axes together, N (or the signal's unit). See CalcHighPassRms. Needs at
/// least 3 samples.
double CalcNoise(std::span<const Vec3> f_N, double dt_s, double from_Hz = 20);

/// C2: force steps from tick to tick in just-noticeable differences: |dF| / (0.07 max(|F|, 0.5 N)), where F is the
/// force before the step and 7 % is the difference that people perceive (Pang, Tan and Durlach 1991). Needs at least 2
/// samples.
struct TickSteps {
  double p999 = 0;  // 99.9 % of the steps are at most this
  double max = 0;
};
TickSteps CalcTickSteps(std::span<const Vec3> f_N);
/// Returns the smallest change of a force that people perceive, N, by the rule of C2.
double CalcJustNoticeable_N(double force_N);

/// C3: total variation divided by range: 1 for a monotonic or constant signal, more for one that fluctuates. Needs at
/// least 2 samples.
double CalcTotalVariation(std::span<const double> f);

/// C4: events per second: contact begins or ends (f changes from 0 to another value or back), and the signal reverses
/// by more than `min_reversal` (a hysteresis, in the signal's unit, not negative). Needs at least 2 samples.
struct Toggles {
  double contact_per_s = 0;
  double turns_per_s = 0;
};
Toggles CountToggles(std::span<const double> f, double dt_s, double min_reversal);

/// C5: power at f_Hz relative to that at the neighbouring frequencies, dB (Welch's method, Hann windows that overlap by
/// half). For noise it scatters by about 2 dB around 0; power below 1e-9 of the signal counts as zero. f_Hz is at most
/// half the sampling rate. Needs at least 8 periods of f_Hz and 64 samples.
double CalcLineProminence_dB(std::span<const double> f, double dt_s, double f_Hz);

/// C6: an oscillation that does not decay while nothing excites it. Pass the part of the signal after any kick has had
/// time to decay: otherwise a large oscillation that leaves a small one behind would be reported as decaying.
struct Oscillation {
  double correlation = 0;    // highest peak of the detrended signal's autocorrelation beyond its first zero; 0: no peak
  double frequency_Hz = 0;   // of that peak; the signal must hold at least three periods. 0: no peak
  double amplitude = 0;      // of the detrended signal, sqrt(2) * RMS
  double log_decrement = 0;  // of the envelope, per period: above 0 it decays, below 0 it grows
  // correlation > 0.5, amplitude above `min_amplitude`, and the envelope loses less than a tenth from start to end
  bool is_limit_cycle = false;
};
/// Needs at least 16 samples. `min_amplitude` is in the signal's unit.
Oscillation FindOscillation(std::span<const double> f, double dt_s, double min_amplitude);

/// C7: perceived level of the force in a hand that holds `mass_kg`, dB above the vibration threshold (maximum over
/// third octaves from 10 to 500 Hz, up to half the sampling rate; after Choi and Tan 2004). Perceptible only if
/// above 0. -200 if there is no vibration. Needs at least half a second. For the reliability of the threshold see
/// CalcVibrationThreshold_um.
double CalcSensationLevel_dB(std::span<const double> f_N, double dt_s, double mass_kg);

/// Returns the amplitude, um, of the weakest vibration at f_Hz that can be felt through an object in the hand. f_Hz is
/// clamped to 10 to 500 Hz.
double CalcVibrationThreshold_um(double f_Hz);

/// C8: percentile (`fraction` 0 to 1) of the angle between successive forces, degrees, over the pairs in which both
/// forces are above min_N; 0 if there are none. Needs at least 2 samples.
double CalcTurn_deg(std::span<const Vec3> f_N, double fraction, double min_N = 0.5);

/// C9: root mean square, mm, of a motion between 1 and 20 Hz while no motion is intended: the part above 1 Hz minus the
/// part above 20 Hz, both calculated as in C1. Needs at least a second.
double CalcAliveness(std::span<const Vec3> p_mm, double dt_s);

}  // namespace kerf
