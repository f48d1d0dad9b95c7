// What contact remembers from step to step, so that it can hold without ever throwing.
#pragma once

#include <algorithm>
#include <vector>

namespace kerf {

/// How deep each contact point of the tool stands in the bone, by the springs that hold it.
///
/// A point is found deeper than its spring knew when the bone is uneven, the tool was set down in it, or the grid blurs
/// a corner. Taking it out would be energy from nowhere: a spring is drawn out at once no further than it was, and
/// beyond that at `kSpeed` while the energy that this takes has been lost before (the account of the coupled tick).
class PushOut {
 public:
  static constexpr double kSpeed_mm_per_s = 2;

  explicit PushOut(std::size_t points) : known_mm_(points, 0.0) {}

  /// Depth that point `i`'s spring may have at the start of a step. Tick-safe.
  double Limit(int i, double found_mm, double step_s, bool may_rise) const {
    const double most = known_mm_[i] + (may_rise ? kSpeed_mm_per_s * step_s : 0);
    return std::min(found_mm, most);
  }
  double known_mm(int i) const { return known_mm_[i]; }
  void set_known_mm(int i, double depth_mm) { known_mm_[i] = depth_mm; }
  void Ease(double share) {
    for (double& depth_mm : known_mm_) depth_mm *= share;
  }
  void Forget() { std::fill(known_mm_.begin(), known_mm_.end(), 0.0); }
  std::size_t size() const { return known_mm_.size(); }

 private:
  std::vector<double> known_mm_;
};

}  // namespace kerf
