// Growth rate of an oscillation from its turning points.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace kerf {

/// Successive swings of a signal: the times of its turning points and the distances between them. A turning point
/// counts once the signal has come back from it by a fraction of the previous swing: where a contact in the kerf opens
/// or closes, a swing has a dent, which would appear as two turning points.
class Swings {
 public:
  void Add(double t_s, double value) {
    if (count_ >= 2 && (value - y1_) * (y1_ - y0_) < 0) {
      // The turning point is that of a parabola through three samples.
      const double top = y1_ - (value - y0_) * (value - y0_) / (8 * (y0_ - 2 * y1_ + value));
      if (upwards_ == 0) upwards_ = y1_ > value ? 1 : -1;
      if (!turning_ || upwards_ * (top - top_) > 0) {
        turning_ = true;
        top_ = top;
        top_time_s_ = t_s;
      }
    }
    constexpr double kDent = 0.05;  // the largest of a disc in its kerf is 0.036
    const double last_swing = turns_ > 1 ? std::abs(last_top_ - before_last_top_) : std::abs(top_);
    if (turning_ && upwards_ * (top_ - value) > kDent * last_swing) Turn();
    y0_ = y1_;
    y1_ = value;
    ++count_;
  }

  std::size_t size() const { return log_swing_.size(); }
  double log_swing(std::size_t i) const { return log_swing_[i]; }

  /// Returns the growth rate, 1/s, by least squares over all swings from `first` on.
  double CalcGrowth(std::size_t first) const {
    const double n = static_cast<double>(size() - first);
    double t_mean = 0;
    double y_mean = 0;
    for (std::size_t i = first; i < size(); ++i) {
      t_mean += time_s_[i] / n;
      y_mean += log_swing_[i] / n;
    }
    double ty = 0;
    double tt = 0;
    for (std::size_t i = first; i < size(); ++i) {
      ty += (time_s_[i] - t_mean) * (log_swing_[i] - y_mean);
      tt += (time_s_[i] - t_mean) * (time_s_[i] - t_mean);
    }
    return tt > 0 ? ty / tt : 0;
  }

 private:
  void Turn() {
    if (turns_++ > 0) {
      time_s_.push_back(top_time_s_);
      log_swing_.push_back(std::log(std::max(std::abs(top_ - last_top_), 1e-300)));
    }
    before_last_top_ = last_top_;
    last_top_ = top_;
    turning_ = false;
    upwards_ = -upwards_;
  }

  std::vector<double> time_s_;
  std::vector<double> log_swing_;
  double y0_ = 0;
  double y1_ = 0;
  int count_ = 0;
  int upwards_ = 0;       // 1 if the next turning point is a maximum, -1 if it is a minimum
  bool turning_ = false;  // whether the signal has turned at `top_`
  double top_ = 0;
  double top_time_s_ = 0;
  double last_top_ = 0;
  double before_last_top_ = 0;
  int turns_ = 0;
};

}  // namespace kerf
