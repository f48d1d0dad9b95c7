// Closed orbits of a hand, in and out of a block of bone. No energy may be returned over an orbit.
#pragma once

#include <cmath>
#include <random>

#include "device/devices/intention.h"
#include "loop/haptics/held_saw.h"

namespace kerf::test {

/// Returns a double in [0, 1), the same on every machine.
inline double Uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11U) * 0x1p-53;
}
inline double Uniform(std::mt19937_64& random, double lower, double upper) {
  return lower + (upper - lower) * Uniform(random);
}

/// Sum of two waves along each axis about a centre. It is closed after `seconds` and contains no frequency above 10 Hz,
/// like intended motions of a hand.
struct HandOrbit {
  double seconds = 2;
  Pose X_WH_middle;
  struct Wave {
    Vec3 amplitude_mm{0};
    Vec3 phase{0};
    double f_Hz = 0;
  };
  Wave waves[2];
  double tilt_rad = 0;  // amplitude of the disc's tilt about x, with the first wave

  Intention At(double t_s) const {
    Intention intention;
    Vec3 p = X_WH_middle.p_AB;
    Vec3 v(0);
    for (const Wave& wave : waves) {
      const double w = 4 * kHalfPi * wave.f_Hz;
      for (int k = 0; k < 3; ++k) {
        p[k] += wave.amplitude_mm[k] * std::sin(w * t_s + wave.phase[k]);
        v[k] += w * wave.amplitude_mm[k] * std::cos(w * t_s + wave.phase[k]);
      }
    }
    const double angle = tilt_rad * std::sin(4 * kHalfPi * waves[0].f_Hz * t_s + waves[0].phase.y);
    intention.X_WH = {glm::angleAxis(angle, Vec3(1, 0, 0)) * X_WH_middle.R_AB, p};
    intention.v_W_mm_per_s = v;
    return intention;
  }
};

/// Draws an orbit over a block with its top at z = 0: it presses on the top, rubs along it and leaves it again.
/// `reach_mm`: largest amplitude; `max_Hz`: largest frequency of the waves; `deep`: most of the orbit is below the
/// top, for a saw that cuts.
inline HandOrbit DrawOrbit(std::mt19937_64& random, double reach_mm = 4, double max_Hz = 4, bool deep = false) {
  HandOrbit orbit;
  const double z_mm = (deep ? Uniform(random, -1.2, -0.4) : Uniform(random, -0.3, 0.6)) * reach_mm;
  orbit.X_WH_middle = Upright(Vec3(0, 0, 11 + z_mm));
  const int max_cycles = static_cast<int>(max_Hz * orbit.seconds);
  for (int i = 0; i < 2; ++i) {
    HandOrbit::Wave& wave = orbit.waves[i];
    wave.f_Hz = (1 + std::floor(Uniform(random, 0, i == 0 ? 3 : max_cycles))) / orbit.seconds;
    const double fraction = i == 0 ? 1 : 0.3;
    wave.amplitude_mm = fraction * reach_mm * Vec3(Uniform(random), 0.2 * Uniform(random), Uniform(random, 0.3, 1));
    wave.phase = 4 * kHalfPi * Vec3(Uniform(random), Uniform(random), Uniform(random));
  }
  orbit.tilt_rad = Uniform(random, 0, 0.03);
  return orbit;
}

}  // namespace kerf::test
