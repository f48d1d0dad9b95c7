// Spectrum of the force of individual teeth, from a run with the effect "tooth_vibration".
#pragma once

#include <array>
#include <complex>
#include <string>
#include <vector>

#include "cut/effects/plan.h"
#include "cut/effects/tooth_vibration.h"
#include "view/plot/plot.h"

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
    double begin_s = 0;      // start of the interval
    double seconds = 0;      // its length; the bins are 1 / seconds apart
    double spindle_Hz = 0;   // or strokes per second
    bool strokes = false;    // the teeth move to and fro: the lines are at multiples of spindle_Hz
    int teeth = 0;           // that pass in a turn; 0 with a stroke
    double passing_Hz = 0;   // teeth that pass a point per second, mean
    bool has_set = false;    // the teeth are bent to alternate sides
    double carried_Hz = 0;   // lines up to this frequency are part of the tick's force; 0: other parts are
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
  double passes_ = 0;  // teeth that pass a point in a turn or a whole stroke
  std::vector<Moment> moments_;
};

/// Plots a spectrum that is not empty.
PlotSpec MakeSpectrumPlot(const SpectrumTrack::Spectrum& spectrum, const std::string& name);
/// Draws the spectrum. Returns false if there was nothing to draw.
bool WriteSpectrumPicture(const SpectrumTrack::Spectrum& spectrum, const std::string& name, const std::string& path);

}  // namespace kerf
