// What tells a steady force from one that chatters, swings or seems alive: measures of signals sampled every dt_s.
// C1 to C9 are the names under which docs/stability.md lists them.
#pragma once

#include <span>

#include "kerf/geometry.h"

namespace kerf {

/// C1: root mean square above 20 Hz, all three axes together, N (or the signal's unit). See CalcHighPassRms.
double CalcNoise(std::span<const Vec3> f_N, double dt_s, double from_Hz = 20);

/// C2: steps from tick to tick in just-noticeable differences of force: |dF| / (0.07 max(|F|, 0.5 N)), 7 % being what
/// people tell apart (Pang, Tan and Durlach 1991).
struct TickSteps {
  double p999 = 0;
  double max = 0;
};
TickSteps CalcTickSteps(std::span<const Vec3> f_N);

/// C3: total variation over range: 1 for a signal that only rises or only falls, more the more it wavers. 1 for a
/// constant.
double CalcTotalVariation(std::span<const double> f);

/// C4: how often a second contact comes and goes (|f| passes above 0) and the force's change turns round by more than
/// `least` (a hysteresis, in the signal's unit).
struct Toggles {
  double contact_per_s = 0;
  double turns_per_s = 0;
};
Toggles CountToggles(std::span<const double> f, double dt_s, double least);

/// C5: how far the power at f_Hz stands out above that of the frequencies around it, dB (Welch's method, Hann windows).
/// f_Hz below half the sampling rate.
double CalcLineProminence_dB(std::span<const double> f, double dt_s, double f_Hz);

/// C6: an oscillation that does not die out while nothing drives it.
struct Oscillation {
  double correlation = 0;       // highest peak of the autocorrelation of the detrended signal beyond its first zero
  double frequency_Hz = 0;      // of that peak
  double amplitude = 0;         // of the detrended signal, sqrt(2) * RMS
  double log_decrement = 0;     // per period, of the envelope: above 0 it dies out, below 0 it grows
  bool is_limit_cycle = false;  // correlation > 0.5, amplitude above `least`, and log_decrement not above 0
};
Oscillation FindOscillation(std::span<const double> f, double dt_s, double least);

/// C7: what a hand that holds `mass_kg` feels of the force, dB above the threshold of vibration (Choi and Tan 2004: the
/// largest over third octaves from 10 to 500 Hz). Not above 0: not felt. Source of the threshold: at the function.
double CalcSensationLevel_dB(std::span<const double> f_N, double dt_s, double mass_kg);

/// C8: percentile (share 0 to 1) of the angle between successive forces, degrees, where both are above least_N.
double CalcTurn_deg(std::span<const Vec3> f_N, double share, double least_N = 0.5);

/// C9: root mean square of a motion between 1 and 20 Hz while nobody wants to move, mm.
double CalcAliveness(std::span<const Vec3> p_mm, double dt_s);

}  // namespace kerf
