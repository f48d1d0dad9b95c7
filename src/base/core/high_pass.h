// High-pass part of a signal.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace kerf {

/// Computes the root mean square of `x`, sampled every dt_s, above cutoff_Hz: after a second-order Butterworth
/// high-pass applied forwards and backwards, which causes no time shift and halves the amplitude at the cut-off. The
/// signal is extended by point reflection at its ends, so that a straight line gives 0. Returns 0 for fewer than 3
/// samples. Throws kerf::Error unless 0 < cutoff_Hz < 1 / (2 dt_s).
double CalcHighPassRms(std::span<const double> x, double dt_s, double cutoff_Hz);

/// Second-order filter section, transposed direct form II.
struct FilterSection {
  double b0, b1, b2, a1, a2;
  double z1 = 0, z2 = 0;
  /// Sets the state reached after a constant input `first`, for which a high-pass outputs 0.
  void Begin(double first);
  double Run(double in);
};

/// Computes the result of CalcHighPassRms() sample by sample, up to rounding, in bounded memory. The backward filter
/// runs in blocks, each started far enough ahead for its initial state to decay. Not for the tick.
class HighPassRms {
 public:
  /// Throws kerf::Error as CalcHighPassRms() does.
  HighPassRms(double dt_s, double cutoff_Hz);
  void Add(double x);
  /// Returns 0 for fewer than 3 samples. Call once, after the last Add().
  double Finish();
  std::size_t count() const { return count_; }

 private:
  void Forward(double x);
  void Backward(std::size_t first, std::size_t last);

  double dt_s_;
  double cutoff_Hz_;
  std::size_t settle_;
  FilterSection section_;
  std::size_t count_ = 0;
  std::vector<double> head_;     // the first samples, until there are enough for the reflection
  std::vector<double> tail_;     // the last samples, in a ring
  std::vector<double> forward_;  // filtered forwards, not yet backwards
  std::size_t skip_ = 0;         // values at the start of forward_ that belong to the reflection, not to the signal
  double sum_ = 0;
};

}  // namespace kerf
