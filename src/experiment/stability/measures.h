// What tells a steady force from one that chatters, swings or seems alive: measures of signals sampled every dt_s.
// C1 to C9 are the names under which docs/stability.md lists them.
//
// For all of them: a signal that is too short to tell, or has a value that is not finite, gives NaN, which holds no
// bound. A constant is as quiet as can be. Throws Error for a dt_s not above 0 and for a frequency, mass or share out
// of range.
#pragma once

#include <span>

#include "kerf/geometry.h"

namespace kerf {

/// C1: root mean square above 20 Hz, all three axes together, N (or the signal's unit). See CalcHighPassRms. At least 3
/// samples.
double CalcNoise(std::span<const Vec3> f_N, double dt_s, double from_Hz = 20);

/// C2: steps from tick to tick in just-noticeable differences of force: |dF| / (0.07 max(|F|, 0.5 N)), F the force
/// before the step, 7 % being what people tell apart (Pang, Tan and Durlach 1991). At least 2 samples.
struct TickSteps {
  double p999 = 0;  // 99.9 % of the steps are no larger
  double max = 0;
};
TickSteps CalcTickSteps(std::span<const Vec3> f_N);
/// The least change of a force that people tell, N: as above.
double CalcJustNoticeable_N(double force_N);

/// C3: total variation over range: 1 for a signal that only rises or only falls, more the more it wavers. 1 for a
/// constant. At least 2 samples.
double CalcTotalVariation(std::span<const double> f);

/// C4: how often a second contact comes or goes (f passes from 0 to something else or back) and the signal turns round
/// by more than `least` (a hysteresis, in the signal's unit, not negative). At least 2 samples.
struct Toggles {
  double contact_per_s = 0;
  double turns_per_s = 0;
};
Toggles CountToggles(std::span<const double> f, double dt_s, double least);

/// C5: how far the power at f_Hz stands out above that of the frequencies around it, dB (Welch's method, Hann windows
/// that overlap by half). For noise it scatters by some 2 dB about 0; what is below 1e-9 of the signal is nothing. f_Hz
/// up to half the sampling rate; at least 8 periods of it and 64 samples.
double CalcLineProminence_dB(std::span<const double> f, double dt_s, double f_Hz);

/// C6: an oscillation that does not die out while nothing drives it. Give it the part after a kick has had time to die
/// out: of a large one that leaves a small one behind, it would say that it dies out.
struct Oscillation {
  double correlation = 0;    // highest peak of the detrended signal's autocorrelation beyond its first zero; 0: none
  double frequency_Hz = 0;   // of that peak; three periods at least are looked at. 0: none
  double amplitude = 0;      // of the detrended signal, sqrt(2) * RMS
  double log_decrement = 0;  // per period, of the envelope: above 0 it dies out, below 0 it grows
  // correlation > 0.5, amplitude above `least`, and of the envelope less than a tenth is lost from start to end
  bool is_limit_cycle = false;
};
/// At least 16 samples. `least` in the signal's unit.
Oscillation FindOscillation(std::span<const double> f, double dt_s, double least);

/// C7: what a hand that holds `mass_kg` feels of the force, dB above the threshold of vibration (the largest over third
/// octaves from 10 to 500 Hz, as far as half the sampling rate; after Choi and Tan 2004). Not above 0: not felt. -200
/// when there is nothing. At least half a second. How sure the threshold is: CalcVibrationThreshold_um.
double CalcSensationLevel_dB(std::span<const double> f_N, double dt_s, double mass_kg);

/// Amplitude of the weakest vibration that is felt through an object in the hand, um, at 10 to 500 Hz; beyond, that of
/// the nearer end.
double CalcVibrationThreshold_um(double f_Hz);

/// C8: percentile (share 0 to 1) of the angle between successive forces, degrees, where both are above least_N; 0 when
/// none are. At least 2 samples.
double CalcTurn_deg(std::span<const Vec3> f_N, double share, double least_N = 0.5);

/// C9: root mean square of a motion between 1 and 20 Hz while nobody wants to move, mm: what is above 1 Hz less what is
/// above 20 Hz, both as in C1. At least a second.
double CalcAliveness(std::span<const Vec3> p_mm, double dt_s);

}  // namespace kerf
