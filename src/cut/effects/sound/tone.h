// The tone of a motor and its cut: figures of a tick made into samples. Outside the tick.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace kerf {

/// What a tick says of the tone.
struct ToneFrame {
  float dt_s = 0;
  float spindle_Hz = 0;
  float load_W = 0;  // power of cutting
  // Amplitudes of the teeth's force, as lines at 1, N / 2 and N times the spindle's frequency.
  float runout_N = 0;
  float set_N = 0;
  float passing_N = 0;
};

struct ToneParams {
  int rate_Hz = 48000;  // samples each second
  double motor_order = 7;
  // The most that each part may take of full scale.
  double motor_level = 0.2;
  double teeth_level = 0.3;
  double noise_level = 0.3;
  // At which a part has half of that.
  double half_W = 20;
  double half_N = 0.5;
};

/// Turns frames into samples, one frame after the other. Each partial has a phase of its own that goes on from frame to
/// frame; frequencies and amplitudes go linearly from one frame's to the next one's. A partial fades between 0.40 and
/// 0.45 of the sampling rate, and is silent above. The sum of the levels bounds every sample: nothing is clipped.
class Tone {
 public:
  /// `teeth`: that pass in a turn.
  Tone(const ToneParams& params, int teeth);

  /// Appends the frame's samples, within +-(motor_level + teeth_level + noise_level): as many as bring their number up
  /// to the time that all frames took. What is not a finite number counts as 0, a frame lasts at most a second.
  void Render(const ToneFrame& frame, std::vector<float>& samples);

  enum { kMotor1, kMotor2, kMotor3, kWhine, kWhine2, kRunout, kSet, kPassing, kPassing2, kPartials };
  /// Times the spindle's frequency; 0: none.
  const std::array<double, kPartials>& orders() const { return orders_; }
  /// Of the partials as a frame makes them, of full scale; without the fading near half the sampling rate.
  std::array<double, kPartials> CalcAmplitudes(const ToneFrame& frame) const;
  /// Likewise; the greatest that the noise can be.
  double CalcNoise(const ToneFrame& frame) const;

 private:
  double NextNoise();

  ToneParams params_;
  std::array<double, kPartials> orders_{};
  std::array<double, kPartials> turns_{};  // phases, 0 to 1
  std::array<double, kPartials> amplitudes_{};
  double noise_amplitude_ = 0;
  double spindle_Hz_ = 0;
  double owed_ = 0;  // of a sample
  bool fresh_ = true;
  std::uint64_t dice_ = 0x6b657266;
  double fine_ = 0, finer_ = 0, slow_ = 0;  // states of the noise's filters
  double fine_share_, slow_share_;
};

}  // namespace kerf
