// Spectrum of the force of individual teeth, from a run with the effect "tooth_vibration".
#pragma once

#include <array>
#include <complex>
#include <string>
#include <vector>

#include "cut/effects/plan.h"
#include "cut/effects/tooth_vibration.h"

namespace kerf {

/// Records the spectral lines of each tick. Does nothing if the plan lacks the effect.
class SpectrumTrack {
 public:
  SpectrumTrack() = default;
  explicit SpectrumTrack(const EffectPlan& plan);

  /// Call after each tick, in the thread that runs the tick.
  void Take(double dt_s);
  /// Call before the plan is destroyed.
  void Detach() { effect_ = nullptr; }

  struct Spectrum {
    double begin_s = 0;  // start of the interval
    double seconds = 0;  // its length; the bins are 1 / seconds apart
    double spindle_Hz = 0;
    int teeth = 0;
    double carried_Hz = 0;   // lines up to this frequency are part of the tick's force
    std::vector<double> mN;  // per bin, all three axes combined
  };
  /// Computes the spectrum of the interval with the largest lines, 1 s long or shorter for a shorter run; empty if
  /// there were no lines.
  Spectrum CalcSpectrum() const;

 private:
  struct Moment {
    float dt_s;
    float spindle_Hz;
    std::array<std::array<std::complex<float>, 3>, ToothVibrationEffect::kLines> amplitude_N;
  };
  const ToothVibrationEffect* effect_ = nullptr;
  std::array<int, ToothVibrationEffect::kLines> orders_{};
  std::vector<Moment> moments_;
};

/// Draws the spectrum. Returns false if there was nothing to draw.
bool WriteSpectrumPicture(const SpectrumTrack::Spectrum& spectrum, const std::string& name, const std::string& path);

}  // namespace kerf
