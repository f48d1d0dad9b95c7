// Tone of a motor and its cut: converts the values that a tick records to samples, outside the tick.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace kerf {

/// Inputs of the tone from one tick.
struct ToneFrame {
  float dt_s = 0;
  float spindle_Hz = 0;
  float load_W = 0;  // cutting power
  // Amplitudes of the teeth's force, as lines at 1, N / 2 and N times the spindle frequency for N teeth.
  float runout_N = 0;
  float set_N = 0;
  float passing_N = 0;
};

struct ToneParams {
  int rate_Hz = 48000;  // samples per second
  double motor_order = 7;
  // Maximum amplitude of each part, relative to full scale.
  double motor_level = 0.2;
  double teeth_level = 0.3;
  double noise_level = 0.3;
  // Power and force at which a part has half of its maximum amplitude.
  double half_W = 20;
  double half_N = 0.5;
};

/// Converts frames to samples, one frame after the other. Each partial has its own phase, which continues from frame to
/// frame. Frequencies and amplitudes change linearly from the values of one frame to those of the next. A partial fades
/// out between 0.40 and 0.45 of the sampling rate and is silent above. The sum of the levels bounds every sample, so
/// that nothing is clipped.
class Tone {
 public:
  /// `teeth`: number of teeth that pass per turn or double stroke, a real number.
  Tone(const ToneParams& params, double teeth);

  /// Appends the frame's samples, within +-(motor_level + teeth_level + noise_level). Their total number corresponds to
  /// the total time of all frames. Values that are not finite count as 0, and a frame lasts at most 1 s.
  void Render(const ToneFrame& frame, std::vector<float>& samples);

  enum { kMotor1, kMotor2, kMotor3, kWhine, kWhine2, kRunout, kSet, kPassing, kPassing2, kPartials };
  /// Multiples of the spindle frequency; 0: none.
  const std::array<double, kPartials>& orders() const { return orders_; }
  /// Returns the amplitudes of the partials, relative to full scale, without the fading near half the sampling rate.
  std::array<double, kPartials> CalcAmplitudes(const ToneFrame& frame) const;
  /// Returns the maximum amplitude of the noise, relative to full scale.
  double CalcNoise(const ToneFrame& frame) const;

 private:
  double NextNoise();

  ToneParams params_;
  std::array<double, kPartials> orders_{};
  std::array<double, kPartials> turns_{};  // phases, 0 to 1
  std::array<double, kPartials> amplitudes_{};
  double noise_amplitude_ = 0;
  double spindle_Hz_ = 0;
  double owed_ = 0;  // fraction of a sample carried to the next frame
  bool fresh_ = true;
  std::uint64_t random_state_ = 0x6b657266;
  double fine_ = 0, finer_ = 0, slow_ = 0;  // states of the noise's filters
  double fine_fraction_, slow_fraction_;
};

}  // namespace kerf
