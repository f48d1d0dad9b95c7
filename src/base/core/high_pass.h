// What of a signal is fast.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace kerf {

/// Root mean square of `x`, sampled every dt_s, above cutoff_Hz: after a second-order Butterworth high-pass forwards
/// and backwards, which shifts nothing in time and halves what is at the cut-off. The ends are continued by reflection
/// in the end points, so that a straight line is nothing. 0 for fewer than 3 samples. Throws Error unless 0 < cutoff_Hz
/// < 1 / (2 dt_s).
double CalcHighPassRms(std::span<const double> x, double dt_s, double cutoff_Hz);

/// A second-order section, transposed direct form II.
struct FilterSection {
  double b0, b1, b2, a1, a2;
  double z1 = 0, z2 = 0;
  /// As if the input had been at `first` for ever, of which a high-pass gives 0.
  void Begin(double first);
  double Run(double in);
};

/// The same figure of a signal that comes sample by sample, to rounding, in memory that does not grow. The way back
/// of the filter is run in blocks, each begun so far ahead that its beginning is forgotten. Not for the tick.
class HighPassRms {
 public:
  /// Throws Error as CalcHighPassRms.
  HighPassRms(double dt_s, double cutoff_Hz);
  void Add(double x);
  /// 0 for fewer than 3 samples. Once, after the last Add().
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
  std::vector<double> head_;     // the first samples, until there are enough to reflect
  std::vector<double> tail_;     // the last ones, in a ring
  std::vector<double> forward_;  // filtered once, not yet back
  std::size_t skip_ = 0;         // at its beginning: of the reflection, not of the signal
  double sum_ = 0;
};

}  // namespace kerf
