// Progress of lengthy work, with an estimate of the time that is left.
#pragma once

#include <deque>
#include <optional>
#include <string>

namespace kerf {

struct WorkProgress {
  std::string stage;                   // the work in progress, such as "making the bone"
  double fraction = 0;                 // completed part of the stage, 0 to 1
  std::optional<double> seconds_left;  // of the stage; none while it cannot be estimated
};

/// Estimates the time that is left from the rate at which the work went on lately. Not thread-safe.
class ProgressMeter {
 public:
  /// Returns the time of a clock that never goes back, for the functions below.
  static double Now_s();
  /// Call when progress is reported. A fraction below an earlier one of the
  /// same stage is ignored.
  void Set(const std::string& stage, double fraction, double now_s);
  /// The estimate becomes available after 1 s and a fiftieth of the stage. It is that of the rate in the latest half of
  /// the elapsed time, and follows it within seconds, so that it does not jump where a part of the work is slower, but
  /// rises if the work takes longer than it seemed. Between reports, the fraction goes on at the
  /// rate until then, ever slower; it never goes back, and without a report it does not reach the end.
  WorkProgress Get(double now_s) const;

 private:
  struct Report {
    double at_s;
    double fraction;
  };

  std::string stage_;
  double fraction_ = 0;           // as reported
  double shown_ = 0;              // at the last increase, at least as large
  double began_s_ = 0;            // the stage
  double set_s_ = 0;              // the last increase of the fraction
  std::optional<double> left_s_;  // estimated at that time
  std::deque<Report> reports_;    // those that increased it, from the last one before the latest half of the time on
};

}  // namespace kerf
