// The spectrum of what single teeth make of the force, from a run with the effect "tooth_vibration".
#pragma once

#include <array>
#include <complex>
#include <string>
#include <vector>

#include "cut/effects/plan.h"
#include "cut/effects/tooth_vibration.h"

namespace kerf {

/// Keeps the lines of each tick. Of a plan without the effect it does nothing.
class SpectrumTrack {
 public:
  SpectrumTrack() = default;
  explicit SpectrumTrack(const EffectPlan& plan);

  /// After a tick; in the thread that makes it.
  void Take(double dt_s);
  /// The plan ends.
  void Detach() { effect_ = nullptr; }

  struct Spectrum {
    double begin_s = 0;  // of the stretch
    double seconds = 0;  // its length: bins are 1 / seconds apart
    double spindle_Hz = 0;
    int teeth = 0;
    double carried_Hz = 0;   // up to there the tick's force has the lines
    std::vector<double> mN;  // by bin, all three axes together
  };
  /// Of the stretch, of 1 s or as long as there is, in which the lines were highest; empty when there was nothing.
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

/// False: there was nothing to draw.
bool WriteSpectrumPicture(const SpectrumTrack::Spectrum& spectrum, const std::string& name, const std::string& path);

}  // namespace kerf
