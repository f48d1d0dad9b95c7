// tooth_vibration: the variation of the force that is due to single teeth. This is the interface for other code.
#pragma once

#include <array>
#include <complex>

#include "cut/effects/effect.h"
#include "kerf/describe.h"

namespace kerf {

struct ToothVibrationParams {
  double runout_um = 5;
  double set_share = 0.1;
  double tangential_share = 0.625;
  double smoothing_ms = 5;
  double max_N = 2;
};

template <typename V>
void Describe(ToothVibrationParams& p, V&& visit) {
  visit("runout_um", p.runout_um, Range{0, 500}, "runout of the rim, once per turn; an assumption");
  visit("set_share", p.set_share, Range{0, 1},
        "sideways force of a set tooth, as a fraction of its thrust; an assumption");
  visit("tangential_share", p.tangential_share, Range{0, 2},
        "cutting force of a tooth, as a fraction of its thrust: 1/1.6, measured 1/1.8 to 1/1.4");
  visit("smoothing_ms", p.smoothing_ms, Range{0.1, 1000}, "time over which the lines follow the cut");
  visit("max_N", p.max_N, Range{0, 100}, "maximum contribution to the tick's force");
}

/// Adds the vibration of single teeth to the force on the hand, as lines at multiples of the spindle frequency.
///
/// The teeth of a stroke pass at changing speed: their lines are multiples of the phase pi s / pitch at the
/// displacement s, instead of the spindle's angle.
class ToothVibrationEffect final : public Effect {
 public:
  ToothVibrationEffect(const ToothVibrationParams& params, const EffectSetup& setup);

  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void Reset() override;
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override { return sizeof(*this); }

  /// Spectral line: force on the tool = Re(amplitude e^(i order theta)), with theta the spindle's angle, or pi s /
  /// pitch. Tool frame, N. With a stroke, the component along y is for motion along +y; it changes its sign with the
  /// motion.
  struct Line {
    int order = 0;  // multiple of theta; 0: none
    std::array<std::complex<double>, 3> amplitude_N{};
    double Magnitude() const;
  };
  enum { kRunout, kSet, kPassing, kPassing2, kLines };
  const std::array<Line, kLines>& lines() const { return lines_; }
  double spindle_Hz() const { return spindle_Hz_; }
  /// Returns the whole vibration `delay_s` after the end of the tick, for sound and for actuators that are faster than
  /// the tick. Tool frame, N. Tick-safe.
  Vec3 Sample(double delay_s) const;

 private:
  /// Angle of the lines, and its rate.
  struct Angle {
    double theta_rad = 0;
    double rate_Hz = 0;        // of theta
    double modulation_Hz = 0;  // at which the rate changes
    double way = 1;            // direction of a stroke: 1 or -1
  };
  Angle FindAngle(double delay_s) const;

  ToothVibrationParams params_;
  int teeth_;  // with a stroke 2: orders 1, 2 and 4 of theta
  Drive drive_;
  double amplitude_mm_;  // of the stroke
  double pitch_mm_;
  double phase_rad_ = 0;  // of the stroke
  std::array<Line, kLines> lines_{};
  std::array<std::array<std::complex<double>, 3>, kLines> sums_{};  // in this tick, weighted by time
  double summed_s_ = 0;
  double theta_rad_ = 0;
  double spindle_Hz_ = 0;
  double force_N_ = 0;
  bool awake_ = false;
};

}  // namespace kerf
